/* What the contestants in C share: the scene, the convex programme of its relaxation, and the board as an instrument.

   min over r in K_mu   ½ |V r|² + ½ ALPHA |r|² + qᵀ r,   V = L⁻¹ Hᵀ,  M = L Lᵀ,  q = H v_free + w

   in units in which impulses and the diagonal of W = VᵀV are about 1. `REAL` is double or float. */
#include <malloc.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "scene.h" /* of the script: N, C, ALPHA, mass, push, before, jacobian, offset, mu */

enum { R = 3 * C }; /* rows: of each contact its normal, then two tangents */

static REAL V[N][R], q[R], alpha; /* scaled */
static REAL unit;                 /* of impulses, and with the size of q: */
static REAL impulse_unit;         /* N s */
static double impulses[R];        /* N s, the answer */

/* M = L Lᵀ, then V, alpha and the unit of impulses. */
static REAL L[N][N];
static void prepare_programme(void)
{
    for (int i = 0; i < N; i++) {
        for (int j = 0; j <= i; j++) {
            REAL sum = (REAL)mass[i][j];
            for (int k = 0; k < j; k++) sum -= L[i][k] * L[j][k];
            L[i][j] = i == j ? (REAL)sqrt(sum) : sum / L[j][j];
        }
    }
    REAL trace = 0;
    for (int row = 0; row < R; row++) {
        for (int i = 0; i < N; i++) {
            REAL sum = (REAL)jacobian[row][i];
            for (int k = 0; k < i; k++) sum -= L[i][k] * V[k][row];
            V[i][row] = sum / L[i][i];
            trace += V[i][row] * V[i][row];
        }
    }
    unit = (REAL)sqrt(R / trace);
    for (int i = 0; i < N; i++)
        for (int row = 0; row < R; row++) V[i][row] *= unit;
    alpha = (REAL)ALPHA * unit * unit;
}

/* q of a free impulse, in units that make its norm 1. */
static void prepare_push(const double *free_impulse)
{
    REAL half[N]; /* L⁻¹ push, and so q = Vᵀ half + w */
    for (int i = 0; i < N; i++) {
        half[i] = (REAL)free_impulse[i];
        for (int k = 0; k < i; k++) half[i] -= L[i][k] * half[k];
        half[i] /= L[i][i];
    }
    REAL square = 0;
    for (int row = 0; row < R; row++) {
        q[row] = (REAL)offset[row] * unit;
        for (int i = 0; i < N; i++) q[row] += V[i][row] * half[i];
        square += q[row] * q[row];
    }
    const REAL size = (REAL)sqrt(square);
    for (int row = 0; row < R; row++) q[row] /= size;
    impulse_unit = unit * size;
}

/* The board's timer runs at 25 MHz, and with -icount shift=10 an instruction takes 1024 ns. */
#define TIMER ((volatile uint32_t *)0x40000000)

/* Calls `f`: what is measured stands between entry and return, also in a trace. */
__attribute__((noinline)) static void measured(void (*f)(void))
{
    f();
    __asm volatile("");
}

static void run(const char *label, double setting, int iterations, void (*f)(void))
{
    TIMER[2] = 0xFFFFFFFF;
    TIMER[1] = 0xFFFFFFFF;
    TIMER[0] = 1;
    const uint32_t start = TIMER[1];
    measured(f);
    const uint32_t ticks = start - TIMER[1];
    printf("%s %g/%d %lu", label, setting, iterations, (unsigned long)((uint64_t)ticks * 40 / 1024));
    for (int row = 0; row < R; row++) printf(" %.17g", impulses[row]);
    printf("\n");
}

extern unsigned char stack_top[]; /* of link.ld */
enum { STRETCH = 100000, PAINT = 0x5A };

/* Bytes of stack that `f` takes. */
__attribute__((noinline)) static unsigned stack_bytes(void (*f)(void))
{
    volatile unsigned char here = 0;
    const uintptr_t top = (uintptr_t)&here;
    volatile unsigned char *const lowest = (volatile unsigned char *)stack_top - STRETCH, *p;
    for (p = lowest; (uintptr_t)p < top - 64; p++) *p = PAINT;
    f();
    for (p = lowest; *p == PAINT; p++) { }
    return (unsigned)(top - (uintptr_t)p);
}
