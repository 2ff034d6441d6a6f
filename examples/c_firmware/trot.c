/* The control loop of examples/firmware in C: forty steps of a quadruped, the same impulses to the bit. For N = 18, D = 3, C = 5
   and float. The last line is the stack that calls took. */
#include "stiction.h"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

enum { BUDGET = 12 }; /* so small that most steps take several calls */

/* Records as examples/embedded/records.rs describes them; the Makefile says where they are. */
__asm__(".section .rodata\n.balign 4\nsteps: .incbin \"" RECORDS "\"\nsteps_end:\n.text");
extern const unsigned char steps[], steps_end[];
static const unsigned char *next = steps;

static void take(void *to, size_t bytes)
{
    memcpy(to, next, bytes);
    next += bytes;
}

extern unsigned char stack_top[]; /* of link.ld */
enum { STRETCH = 12000, PAINT = 0x5A };
#define LOWEST ((volatile unsigned char *)stack_top - STRETCH)
static uintptr_t top;

/* Paints the stack below a caller, so that `depth` tells how much of it a call took. */
__attribute__((noinline)) static void paint(void)
{
    volatile unsigned char here = 0;
    top = (uintptr_t)&here;
    for (volatile unsigned char *p = LOWEST; (uintptr_t)p < top - 32; p++) *p = PAINT;
}

__attribute__((noinline)) static void depth(unsigned *most)
{
    const volatile unsigned char *p = LOWEST;
    while (*p == PAINT) p++;
    const unsigned depth = (unsigned)(top - (uintptr_t)p);
    if (depth > *most) *most = depth;
}

int main(void)
{
    static stiction solver, exact; /* `exact` solves further than float can, through all phases, for its stack */
    unsigned stack = 0, stack_exact = 0, stack_scene = 0;
    static float mass[STICTION_N][STICTION_N], jacobian[STICTION_D][STICTION_N];
    static stiction_solution good;
    enum stiction_status status = STICTION_SOLVED;
    if (stiction_init(&solver) != STICTION_OK || stiction_init(&exact) != STICTION_OK) return 1;

    for (int step = 1; next < steps_end && status == STICTION_SOLVED; step++) {
        float push[STICTION_N], offset[STICTION_D], mu;
        uint32_t key, count;

        take(&count, sizeof count);
        for (int i = 0; i < STICTION_N; i++) {
            for (int j = 0; j <= i; j++) {
                take(&mass[i][j], sizeof(float));
                mass[j][i] = mass[i][j];
            }
        }
        take(push, sizeof push);
        for (int i = 0; i < STICTION_N; i++) push[i] = -push[i]; /* the records have -M v_free */
        paint();
        if ((status = stiction_set_mass(&solver, STICTION_CONST(mass))) != STICTION_OK) break;
        depth(&stack_scene);
        stiction_set_mass(&exact, STICTION_CONST(mass));
        stiction_clear_contacts(&solver);
        stiction_clear_contacts(&exact);
        for (uint32_t i = 0; i < count && status == STICTION_OK; i++) {
            take(&key, sizeof key);
            take(&mu, sizeof mu);
            take(offset, sizeof offset);
            take(jacobian, sizeof jacobian);
            paint();
            status = stiction_add_contact(&solver, STICTION_CONST(jacobian), offset, mu, key);
            depth(&stack_scene);
            stiction_add_contact(&exact, STICTION_CONST(jacobian), offset, mu, key);
        }
        if (status != STICTION_OK) break;

        paint();
        status = stiction_solve(&solver, push, 1e-4f, BUDGET);
        while (status == STICTION_OUT_OF_BUDGET) /* in firmware: in the next tick */
            status = stiction_resume(&solver, push, 1e-4f, BUDGET);
        depth(&stack);
        paint();
        stiction_solve(&exact, push, 1e-8f, 1000);
        depth(&stack_exact);
        /* Unless they are good enough, the last good impulses stay: by their keys, for contacts come and go. */
        if (stiction_is_usable(&solver, 1e-2f)) stiction_read(&solver, &good);

        printf("%2d", step);
        for (uint32_t i = 0; i < good.count; i++) {
            printf("  %" PRIu32 ":", good.contacts[i].key);
            for (int k = 0; k < STICTION_D; k++) {
                uint32_t bits;
                memcpy(&bits, &good.contacts[i].impulse[k], sizeof bits);
                printf(" %08" PRIx32, bits);
            }
        }
        printf("\n");
    }
    printf("; stack: scene %u, solve %u, all phases %u\n", stack_scene, stack, stack_exact);
    if (status != STICTION_SOLVED) printf("%s\n", stiction_name(status));
    return status != STICTION_SOLVED;
}
