/* TinyMPC, alternating directions with a Riccati factor, in single precision: one stage of its control problem is the programme.

   x_1 = V r with cost ½ |x_1|², inputs r with cost ½ alpha |r|² + qᵀ r and second-order cones. Its projection is one only where mu is 1, so
   normal impulses are scaled by mu. It adds its penalty rho twice to both costs and takes it back once for states: hence Q = 1 - rho. */
#define REAL float
#include "race.h"
#include <tiny_api.hpp>

static TinySolver *solver;
static REAL rho, scale[R];
static int order[R]; /* row of the scene at an input: tangents first, then the normal */
static tinyMatrix linear;

static void set_up(void)
{
    prepare_programme();
    tinyMatrix A = tinyMatrix::Zero(N, N), B(N, R), f = tinyMatrix::Zero(N, 1), Q = tinyMatrix::Zero(N, N), S = tinyMatrix::Zero(R, R);
    VectorXi starts(C), sizes(C);
    tinyVector ones = tinyVector::Ones(C);
    for (int at = 0; at < R; at++) {
        const bool normal = at % 3 == 2;
        order[at] = normal ? at - 2 : at + 1;
        scale[at] = normal ? 1 / (REAL)mu[at / 3] : 1;
        for (int i = 0; i < N; i++) B(i, at) = V[i][order[at]] * scale[at];
        S(at, at) = alpha * scale[at] * scale[at];
    }
    for (int i = 0; i < N; i++) Q(i, i) = 1 - rho;
    for (int i = 0; i < C; i++) {
        starts(i) = 3 * i;
        sizes(i) = 3;
    }
    tiny_setup(&solver, A, B, f, Q, S, rho, N, R, 2, 0);
    VectorXi none(0);
    tiny_set_cone_constraints(solver, none, none, tinyVector(0), starts, sizes, ones);
}

static void set_push(const double *free_impulse)
{
    prepare_push(free_impulse);
    linear = tinyMatrix(R, 1);
    for (int at = 0; at < R; at++) linear(at, 0) = -q[order[at]] * scale[at] / solver->work->R(at);
    tiny_set_u_ref(solver, linear);
}

static int iterations;

static void solve(void)
{
    set_push(push);
    tiny_update_settings(solver->settings, 0, 0, iterations, 1, 0, 0, 0, 1, 0, 0);
    tiny_solve(solver);
    for (int at = 0; at < R; at++) impulses[order[at]] = solver->work->zcnew(at, 0) * scale[at] * impulse_unit;
}

static void clean_up(void)
{
    delete solver->solution;
    delete solver->cache;
    delete solver->settings;
    delete solver->work;
    delete solver;
}

static void both(void)
{
    set_up();
    solve();
}

int main(void)
{
    setvbuf(stdout, NULL, _IOLBF, 256);
    const int arena = mallinfo().arena;
    static const REAL penalties[] = {0.01f, 0.03f, 0.1f, 0.3f, 1, 3};
    static const int counts[] = {5, 10, 15, 20, 30, 40, 60, 80, 120, 160, 240, 400, 800};
    for (unsigned k = 0; k < sizeof penalties / sizeof *penalties; k++) {
        rho = penalties[k];
        for (unsigned i = 0; i < sizeof counts / sizeof *counts; i++) {
            run("prepare", (double)rho, 0, set_up);
                    iterations = counts[i];
            run("convex_cold", (double)rho, iterations, solve);
            clean_up();
            set_up();
                    set_push(before); /* and of its solution the tick goes on */
            tiny_update_settings(solver->settings, 0, 0, 2 * iterations, 1, 0, 0, 0, 1, 0, 0);
            tiny_solve(solver);
            run("convex_warm", (double)rho, iterations, solve);
            clean_up();
        }
    }
    printf("bytes heap %d\n", mallinfo().arena - arena);
    printf("bytes stack %u\n", stack_bytes(both));
    return 0;
}
