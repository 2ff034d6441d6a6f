/* ECOS, an interior point method with sparse factorisation, in double precision: a new programme in each tick, no warm start. */
#define REAL double
#include "race.h"
#include <ecos.h>

enum { ROWS = 2 + N + 2 * R, VARIABLES = R + 1, CONES = 1 + C, LAST = VARIABLES - 1 };

static pfloat G[ROWS * VARIABLES], h[ROWS], c[VARIABLES];
static idxint columns[VARIABLES + 1], rows[ROWS * VARIABLES], cones[CONES];
static idxint iterations;
static pwork *solver;

static int entry(int at, int row, pfloat value)
{
    if (value == 0) return at;
    G[at] = value;
    rows[at] = row;
    return at + 1;
}

/* Variables r and t: min qᵀ r + t, where a rotated cone holds t at ½ |(V, √alpha) r|² or more. */
static void build(void)
{
    const int square = 2 + N + (ALPHA > 0 ? R : 0); /* rows of the rotated cone */
    int at = 0;
    memset(h, 0, sizeof h);
    for (int row = 0; row < R; row++) {
        columns[row] = at;
        for (int i = 0; i < N; i++) at = entry(at, 2 + i, -sqrt(2) * V[i][row]);
        if (ALPHA > 0) at = entry(at, 2 + N + row, -sqrt(2 * alpha));
        at = entry(at, square + row, row % 3 == 0 ? -mu[row / 3] : -1);
        c[row] = q[row];
    }
    columns[LAST] = at;
    at = entry(at, 0, -1);
    at = entry(at, 1, -1);
    columns[VARIABLES] = at;
    c[LAST] = 1;
    h[0] = 1;
    h[1] = -1;
    cones[0] = square;
    for (int i = 0; i < C; i++) cones[1 + i] = 3;
}

static void set_up(void)
{
    prepare_programme();
    prepare_push(push);
    build();
    const int square = cones[0];
    solver = ECOS_setup(VARIABLES, square + R, 0, 0, CONES, cones, 0, G, columns, rows, NULL, NULL, NULL, c, h, NULL);
}

static void solve(void)
{
    solver->stgs->verbose = 0;
    solver->stgs->maxit = iterations;
    solver->stgs->feastol = solver->stgs->abstol = solver->stgs->reltol = 1e-12; /* the judge says what is enough */
    ECOS_solve(solver);
    for (int row = 0; row < R; row++) impulses[row] = solver->x[row] * impulse_unit;
}

static void both(void)
{
    set_up();
    solve();
    ECOS_cleanup(solver, 0);
}

int main(void)
{
    setvbuf(stdout, NULL, _IOLBF, 256);
    const int used = mallinfo().arena;
    for (iterations = 2; iterations <= 30; iterations++) {
        run("prepare", 0, iterations, set_up);
        if (solver == NULL) return 1;
        run("convex_cold", 0, iterations, solve);
        const int done = solver->info->iter < iterations;
        ECOS_cleanup(solver, 0);
        if (done) break;
    }
    printf("bytes heap %d\n", (int)mallinfo().arena - used);
    printf("bytes stack %u\n", stack_bytes(both));
    return 0;
}
