@ Loops whose cycles the manual gives. Behind a name stands what a call takes, written from the manual's tables and sentences by hand, with
@ P for the refill of the pipeline: `test_cycles.py` compares it with the model. The return, BX, takes 1 + P.
    .syntax unified
    .cpu cortex-m4
    .fpu fpv4-sp-d16
    .text
.macro loop name
    .thumb_func
    .global loop_\name
loop_\name:
.endm

loop counted            @ = 1 + 100 * 1 + 99 * (1 + P) + 1 + (1 + P)
    movs r0, #100
1:  subs r0, #1
    bne 1b
    bx lr

loop divide             @ = 1 + 10 * (14 + 1) + 9 * (1 + P) + 1 + (1 + P)
    movs r0, #10
1:  vdiv.f32 s0, s1, s2
    subs r0, #1
    bne 1b
    bx lr

loop divide_and_use     @ = 14 + 1 + 1 + (1 + P)
    vdiv.f32 s0, s1, s2
    vadd.f32 s3, s0, s1
    bx lr

loop root               @ = 14 + (1 + P)
    vsqrt.f32 s0, s1
    bx lr

loop accumulate         @ = 4 * 3 + (1 + P)
    vfma.f32 s0, s4, s5
    vfma.f32 s1, s4, s5
    vmla.f32 s2, s4, s5
    vfms.f32 s3, s4, s5
    bx lr

loop addends            @ = 3 * 3 + (1 + P)
    vfma.f32 s0, s4, s5
    vfma.f32 s0, s6, s7
    vfma.f32 s0, s8, s9
    bx lr

loop product_needed     @ = 1 + (1 + 1) + (3 + 1) + (1 + P)
    vmul.f32 s0, s4, s5
    vadd.f32 s1, s0, s4
    vfma.f32 s2, s1, s4
    bx lr

loop two_loads          @ = 1 + 3 + (1 + P)
    mov r1, sp
    ldr r0, [r1]
    ldr r2, [sp]
    bx lr

loop three_loads        @ = 1 + 4 + (1 + P)
    mov r1, sp
    ldr r0, [r1]
    ldr r2, [r1, #4]
    ldr r3, [sp, #4]
    bx lr

loop load_and_store     @ = 1 + 1 + 3 + (1 + P)
    mov r1, sp
    movs r2, #0
    ldr r0, [r1, r2]
    str r0, [r1, #-64]
    bx lr

loop dependent_loads    @ = 2 + 1 + 2 + 2 + (1 + P)
    mov r1, sp
    sub r1, #64
    str r1, [r1]
    ldr r0, [r1]
    ldr r0, [r0]
    bx lr

loop behind_a_store     @ = 1 + 1 + 2 + (1 + P)
    mov r1, sp
    str r1, [r1, #-64]
    ldr r0, [r1]
    bx lr

loop loads_of_floats    @ = (2 + 1 + 1) + 1 + (1 + 1) + (1 + P)
    vldr s0, [sp]
    vldr s1, [sp]
    vldr s2, [sp]
    vmul.f32 s3, s1, s2
    vmul.f32 s4, s3, s2
    bx lr

loop several            @ = 4 + 9 + 3 + 9 + (1 + P)
    ldm sp, {r0, r1, r2}
    vpush {s0-s7}
    ldrd r0, r1, [sp]
    vpop {s0-s7}
    bx lr

loop two_words          @ = 3 + 3 + 2 + (1 + P)
    vldr d0, [sp]
    vstr d0, [sp, #-64]
    vmov r0, r1, d0
    bx lr

loop multiply           @ = 1 + 1 + 1 + 1 + (1 + P)
    mul r0, r1, r2
    mla r0, r1, r2, r3
    smull r0, r1, r2, r3
    umull r0, r1, r2, r3
    bx lr

loop integer_quotient   @ = D + D + (1 + P)
    udiv r0, r1, r2
    sdiv r0, r1, r2
    bx lr

loop calls              @ = (1 + 2) + (1 + P) + 1 + (1 + P) + 1 + (1 + 2 + P)
    push {r4, lr}
    bl 1f
    movs r0, #0
    pop {r4, pc}
1:  movs r1, #0
    bx lr

loop branches           @ = 1 + 1 + (1 + P) + (1 + P)
    movs r0, #0
    cbnz r0, 1f
    cbz r0, 1f
    nop
1:  bx lr

    .global reset
    .thumb_func
reset:
    movw r0, #0xed88        @ CPACR: FPU on
    movt r0, #0xe000
    mov r1, #0xf00000
    str r1, [r0]
    dsb
    isb
    sub sp, #128
    .irp name, counted, divide, divide_and_use, root, accumulate, addends, product_needed, two_loads, three_loads, load_and_store
    bl loop_\name
    .endr
    .irp name, dependent_loads, behind_a_store, loads_of_floats, several, two_words, multiply, integer_quotient, calls, branches
    bl loop_\name
    .endr
    movs r0, #0x18          @ semihosting: end, well
    movw r1, #0x0026
    movt r1, #0x0002
    bkpt #0xab

    .section .vectors, "a"
    .word 0x20010000, reset
