/* The C interface on this machine, `make test`: answers known on paper, every kind of refusal, nothing written beyond its
   place. Holds for any sizes with at least three velocities, without room for contacts, surfaces or joint rows as well. */
#include "stiction.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(what) ((what) ? (void)0 : failed(#what, __LINE__))
static void failed(const char *what, int line)
{
    fprintf(stderr, "test.c:%d: not so: %s\n", line, what);
    exit(1);
}

/* The phases of stiction_sizes.h: do they prove that a scene is infeasible? Otherwise its budget ends. */
enum { AllPhases, SweepsAndNewton, SweepsOnly, PROVES = STICTION_PHASES == AllPhases };
#define INFEASIBLE (PROVES ? STICTION_INFEASIBLE : STICTION_OUT_OF_BUDGET)
#define JAMMED (PROVES ? STICTION_JAMMED : STICTION_OUT_OF_BUDGET)
/* Sweeps alone reach no more in float: they compute no error with twice the digits. */
#define TOLERANCE ((stiction_real)(STICTION_PHASES == SweepsOnly ? 1e-5 : 3e-6))

static const uint64_t mark = 0xA5A5A5A5A5A5A5A5u;
static struct { uint64_t before; stiction solver; uint64_t after; } place = {mark, {{0}}, mark};
static stiction *const s = &place.solver;
static stiction_real mass[STICTION_N][STICTION_N], jacobian[STICTION_D][STICTION_N], offset[STICTION_D];
static stiction_real free_impulse[STICTION_N];
static stiction_solution solution;

static bool near(stiction_real x, double expected) { return fabs((double)x - expected) < 3 * (double)TOLERANCE; }

static stiction_culprit culprit(void)
{
    stiction_culprit culprit;
    CHECK(stiction_last_culprit(s, &culprit) == STICTION_OK);
    return culprit;
}

static enum stiction_status set_mass(void) { return stiction_set_mass(s, STICTION_CONST(mass)); }

/* 2 kg in all directions, and nothing that holds them. */
static void nothing_there(void)
{
    memset(mass, 0, sizeof mass);
    for (int i = 0; i < STICTION_N; i++) mass[i][i] = 2;
    for (int i = 0; i < STICTION_D && i < STICTION_N; i++) jacobian[i][i] = 1;
    CHECK(set_mass() == STICTION_OK && stiction_clear(s) == STICTION_OK);
}

#if STICTION_C > 0

static const stiction_real (*h)[STICTION_N] = STICTION_CONST(jacobian);

/* One coefficient for all rows. */
static enum stiction_status add(const stiction_real (*rows)[STICTION_N], const stiction_real *w, double mu, uint32_t key)
{
#if STICTION_D <= 3
    return stiction_add_contact(s, rows, w, (stiction_real)mu, key);
#else
    const stiction_real m = (stiction_real)mu;
    return stiction_add_contact_on(s, rows, w, &(stiction_surface){.friction = {m, m}, .spin = m, .roll = {m, m}}, key);
#endif
}

/* A point of 2 kg over a floor: velocity 0 is up, the next ones lie along the floor. */
static void point(double mu)
{
    nothing_there();
    CHECK(add(h, offset, mu, 42) == STICTION_OK);
}

static enum stiction_status solve(double up, double along, uint32_t budget)
{
    free_impulse[0] = (stiction_real)up;
    free_impulse[1] = (stiction_real)along;
    return stiction_solve(s, free_impulse, TOLERANCE, budget);
}

/* M v = free + r on paper: it falls with 2 N s, friction holds mu * 2 N s. */
static void answers(void)
{
    point(0.5);
    CHECK(!stiction_is_usable(s, 1));
    CHECK(stiction_read(s, &solution) == STICTION_OK && solution.status == STICTION_UNSOLVED && solution.count == 0);
    CHECK(solve(-2, 0.75, 1000) == STICTION_SOLVED);
    CHECK(stiction_read(s, &solution) == STICTION_OK && solution.status == STICTION_SOLVED);
    CHECK(solution.count == 1 && solution.work > 0 && solution.error >= 0 && near(solution.error, 0));
    stiction_contact *contact = &solution.contacts[0];
    CHECK(contact->key == 42 && near(contact->impulse[0], 2) && near(contact->velocity[0], 0));
    if (STICTION_D > 1) {
        CHECK(contact->mode == STICTION_STICK && near(contact->impulse[1], -0.75) && near(solution.velocity[1], 0));
        CHECK(solve(-2, 3, 1000) == STICTION_SOLVED && stiction_read(s, &solution) == STICTION_OK);
        CHECK(contact->mode == STICTION_SLIP && near(contact->impulse[1], -1) && near(contact->velocity[1], 1));
        if (STICTION_D <= 3) CHECK(stiction_set_friction(s, 0, 0) == STICTION_OK); /* nothing is factorised for it */
        else point(0); /* a surface cannot lose its friction */
        CHECK(solve(-2, 3, 1000) == STICTION_SOLVED && stiction_read(s, &solution) == STICTION_OK);
        CHECK(near(contact->impulse[1], 0) && near(solution.velocity[1], 1.5));
        if (STICTION_D <= 3) CHECK(stiction_set_friction(s, 0, (stiction_real)0.5) == STICTION_OK);
        else point(0.5);
    }
    CHECK(solve(2, 0, 1000) == STICTION_SOLVED && stiction_read(s, &solution) == STICTION_OK);
    CHECK(contact->mode == STICTION_OPEN && contact->impulse[0] == 0 && near(solution.velocity[0], 1));
    CHECK(solution.contacts[STICTION_C - 1].key == (STICTION_C > 1 ? 0 : 42));

    offset[0] = -3; /* a floor that rises with 3 m/s */
    CHECK(stiction_set_offset(s, 0, offset) == STICTION_OK && solve(0, 0, 1000) == STICTION_SOLVED);
    CHECK(stiction_read(s, &solution) == STICTION_OK && near(solution.velocity[0], 3) && near(contact->impulse[0], 6));
    offset[0] = 0;
    jacobian[0][0] = -1; /* it is the ceiling now */
    CHECK(stiction_set_jacobian(s, 0, h) == STICTION_OK && solve(2, 0, 1000) == STICTION_SOLVED);
    CHECK(stiction_set_offset(s, 0, offset) == STICTION_OK && solve(2, 0, 1000) == STICTION_SOLVED);
    CHECK(stiction_read(s, &solution) == STICTION_OK && near(solution.velocity[0], 0) && near(contact->impulse[0], 2));
    jacobian[0][0] = 1;
    CHECK(stiction_reset(s) == STICTION_OK && stiction_is_usable(s, 0)); /* the solution stays */
}

/* A joint that turns with 3 rad/s and 2 kg m^2 into its stop: a contact without friction, of one row. */
static void stop(void)
{
    point(0.5);
    stiction_real row[STICTION_D][STICTION_N] = {{0}};
    row[0][STICTION_N - 1] = -1;
    if (STICTION_C > 1) CHECK(add(STICTION_CONST(row), offset, 0, 7) == STICTION_OK);
    free_impulse[STICTION_N - 1] = 6;
    CHECK(solve(-2, 0, 1000) == STICTION_SOLVED && stiction_read(s, &solution) == STICTION_OK);
    if (STICTION_C > 1 && STICTION_N > STICTION_D)
        CHECK(near(solution.contacts[1].impulse[0], 6) && near(solution.velocity[STICTION_N - 1], 0));
    free_impulse[STICTION_N - 1] = 0;
}

/* Statuses other than solved. */
static void endings(void)
{
    point(0.5);
    offset[0] = -1; /* two walls that close with 1 m/s each */
    if (STICTION_C > 1) {
        CHECK(stiction_set_offset(s, 0, offset) == STICTION_OK);
        jacobian[0][0] = -1;
        CHECK(add(h, offset, 0, 43) == STICTION_OK);
        CHECK(solve(0, 0, 1000) == INFEASIBLE && !stiction_is_usable(s, (stiction_real)0.1));
        CHECK(stiction_read(s, &solution) == STICTION_OK && solution.status == INFEASIBLE);
        CHECK((solution.contacts[0].certificate[0] > 0 && solution.contacts[1].certificate[0] > 0) == PROVES);
    }
    offset[0] = 0;
    jacobian[0][0] = 1;
#if STICTION_D > 1 && STICTION_D <= 3
    point(1); /* a jaw at 5 degrees that is to be pushed out and jams */
    CHECK(stiction_clear(s) == STICTION_OK);
    offset[0] = (stiction_real)-0.1;
    jacobian[0][0] = (stiction_real)0.0872;
    jacobian[1][0] = (stiction_real)0.9962;
    jacobian[1][1] = 0;
    CHECK(add(h, offset, 1, 44) == STICTION_OK && solve(0, 0, 1000) == JAMMED && !stiction_is_usable(s, (stiction_real)0.1));
    CHECK(stiction_read(s, &solution) == STICTION_OK);
    CHECK((solution.contacts[0].certificate[0] > 0 && solution.contacts[0].certificate[1] < 0) == PROVES);
    offset[0] = 0;
    jacobian[0][0] = 1;
    jacobian[1][0] = 0;
    jacobian[1][1] = 1;
#endif
    /* Contacts that push a point obliquely take more than no work. */
    point(0.5);
    for (int i = 1; i < STICTION_C; i++) {
        jacobian[0][1] = (stiction_real)(0.1 * i);
        CHECK(add(h, offset, 0.3, (uint32_t)i) == STICTION_OK);
    }
    jacobian[0][1] = 0;
    CHECK(stiction_reset(s) == STICTION_OK);
    enum stiction_status status = solve(-2, -3, 0);
    CHECK(status == STICTION_OUT_OF_BUDGET);
    CHECK(stiction_read(s, &solution) == STICTION_OK && solution.status == status);
    CHECK(stiction_is_usable(s, solution.error) && !stiction_is_usable(s, solution.error / 2));
    for (int i = 0; i < 1000 && status == STICTION_OUT_OF_BUDGET; i++)
        status = stiction_resume(s, free_impulse, TOLERANCE, 1);
    CHECK(status == STICTION_SOLVED || status == STICTION_PRECISION_LIMIT);
}

/* The point again, of three velocities: what stands behind them is not read, whatever it is. */
static void velocities(void)
{
    point(0.5);
    CHECK(solve(-2, 0.75, 1000) == STICTION_SOLVED);
    CHECK(stiction_set_velocities(s, STICTION_N) == STICTION_OK && stiction_contact_index(s, 42) == 0);
    CHECK(stiction_set_velocities(s, 0) == STICTION_INVALID_VELOCITY_COUNT && culprit().input == STICTION_INPUT_VELOCITIES);
    CHECK(culprit().row == STICTION_N && culprit().column == -1 && stiction_contact_index(s, 42) == 0);
    CHECK(stiction_set_velocities(s, STICTION_N + 1) == STICTION_INVALID_VELOCITY_COUNT && solve(-2, 0.75, 1000) == STICTION_SOLVED);
    if (STICTION_N > 3) {
        CHECK(stiction_set_velocities(s, 3) == STICTION_OK && stiction_contact_index(s, 42) == STICTION_NO_SUCH_KEY);
        CHECK(solve(-2, 0.75, 1000) == STICTION_MASS_NOT_POSITIVE_DEFINITE);
        for (int i = 0; i < STICTION_N; i++) mass[i][STICTION_N - 1] = mass[STICTION_N - 1][i] = NAN;
        for (int i = 0; i < STICTION_D; i++) jacobian[i][STICTION_N - 1] = NAN;
        free_impulse[STICTION_N - 1] = NAN;
        CHECK(set_mass() == STICTION_OK && add(h, offset, 0.5, 42) == STICTION_OK);
        CHECK(solve(-2, 0.75, 1000) == STICTION_SOLVED && stiction_read(s, &solution) == STICTION_OK);
        CHECK(near(solution.contacts[0].impulse[0], 2) && near(solution.velocity[0], 0) && solution.velocity[STICTION_N - 1] == 0);
        for (int i = 0; i < STICTION_D; i++) jacobian[i][STICTION_N - 1] = 0;
        free_impulse[STICTION_N - 1] = 0;
        CHECK(stiction_set_velocities(s, STICTION_N) == STICTION_OK);
    }
}

/* What is refused, and what it is about. A refused call changes nothing. */
static void refusals(void)
{
    point(0.5);
    CHECK(solve(-2, 0.75, 1000) == STICTION_SOLVED);
    mass[2][1] = NAN;
    CHECK(set_mass() == STICTION_NOT_FINITE);
    CHECK(culprit().input == STICTION_INPUT_MASS && culprit().row == 2 && culprit().column == 1 && culprit().contact == -1);
    mass[2][1] = 1;
    CHECK(set_mass() == STICTION_MASS_NOT_SYMMETRIC && culprit().row == 2 && culprit().column == 1);
    jacobian[0][2] = INFINITY;
    CHECK(stiction_set_jacobian(s, 0, h) == STICTION_NOT_FINITE && culprit().input == STICTION_INPUT_JACOBIAN);
    CHECK(culprit().contact == 0 && culprit().row == 0 && culprit().column == 2);
    jacobian[0][2] = 0;
    CHECK(stiction_set_jacobian(s, 9, h) == STICTION_NO_SUCH_CONTACT && culprit().contact == 9);
    offset[STICTION_D - 1] = NAN;
    CHECK(stiction_set_offset(s, 0, offset) == STICTION_NOT_FINITE && culprit().input == STICTION_INPUT_OFFSET);
    CHECK(culprit().contact == 0 && culprit().row == STICTION_D - 1);
    offset[STICTION_D - 1] = 0;
    CHECK(stiction_set_friction(s, 0, -1) == STICTION_INVALID_FRICTION && culprit().input == STICTION_INPUT_FRICTION);
    for (int i = 1; i < STICTION_C; i++) CHECK(add(h, offset, 1, 1) == STICTION_OK);
    CHECK(add(h, offset, 1, 1) == STICTION_CONTACT_LIST_FULL && culprit().contact == STICTION_C && culprit().key == -1);
    /* Neither half a scene nor one without its mass is solved. */
    CHECK(solve(-2, 0, 10) == STICTION_SCENE_INCOMPLETE && culprit().input == STICTION_INPUT_MASS);
    mass[2][1] = 0;
    CHECK(set_mass() == STICTION_OK && solve(-2, 0, 10) == STICTION_SCENE_INCOMPLETE && culprit().input == STICTION_INPUT_CONTACT);
    point(0.5);
    CHECK(stiction_solve(s, free_impulse, -1, 10) == STICTION_INVALID_TOLERANCE);
    free_impulse[2] = NAN;
    CHECK(stiction_solve(s, free_impulse, 1, 10) == STICTION_NOT_FINITE && culprit().input == STICTION_INPUT_FREE_IMPULSE);
    CHECK(culprit().row == 2);
    stiction_surface surface = {.friction = {1, 1}, .compliance = {0, -1}};
    CHECK(stiction_clear_contacts(s) == STICTION_OK);
    CHECK(stiction_add_contact_on(s, h, offset, &surface, 5) == STICTION_INVALID_COMPLIANCE);
    CHECK(culprit().input == STICTION_INPUT_COMPLIANCE && culprit().contact == 0 && culprit().joint_row == -1);
    if (STICTION_S < STICTION_C) {
        surface.compliance[1] = 0;
        for (int i = 0; i < STICTION_S; i++) CHECK(stiction_add_contact_on(s, h, offset, &surface, 1) == STICTION_OK);
        CHECK(stiction_add_contact_on(s, h, offset, &surface, 1) == STICTION_SURFACE_LIST_FULL);
        CHECK(culprit().contact == STICTION_S && culprit().input == STICTION_INPUT_NONE && culprit().key == -1);
    }
    CHECK(stiction_clear_contacts(s) == STICTION_OK);
    CHECK(stiction_remove_contact(s, 0) == STICTION_NO_SUCH_CONTACT && culprit().contact == 0);
    CHECK(stiction_contact_index(s, 5) == STICTION_NO_SUCH_KEY);
    stiction_contact_impulse impulses[STICTION_C + 1] = {{.key = 1}};
    CHECK(stiction_set_impulses(s, impulses, STICTION_C + 1, NULL, 0) == STICTION_IMPULSE_LIST_FULL);
    CHECK(culprit().input == STICTION_INPUT_INITIAL_IMPULSE && culprit().contact == STICTION_C);
    impulses[0].impulse[STICTION_D - 1] = NAN;
    CHECK(stiction_set_impulses(s, impulses, 1, NULL, 0) == STICTION_NOT_FINITE);
    CHECK(culprit().input == STICTION_INPUT_INITIAL_IMPULSE && culprit().contact == 0 && culprit().row == STICTION_D - 1);
    CHECK(add(h, offset, 0.5, 42) == STICTION_OK);
    CHECK(stiction_solve(s, free_impulse, 1, 10) == STICTION_NOT_FINITE);
    char text[80] = "", cut[10];
    CHECK(stiction_describe(s, text, sizeof text) == STICTION_OK);
    CHECK(strcmp(text, "free impulse: entry (2, 0) is not finite") == 0);
    CHECK(stiction_describe(s, cut, sizeof cut) == STICTION_OK && strcmp(cut, "free impu") == 0);
    CHECK(stiction_describe(s, cut, 0) == STICTION_OK && cut[0] == 'f');
    free_impulse[2] = 0;
    mass[0][0] = -2;
    mass[2][1] = 0;
    CHECK(set_mass() == STICTION_OK && solve(-2, 0, 10) == STICTION_MASS_NOT_POSITIVE_DEFINITE);
    CHECK(culprit().input == STICTION_INPUT_MASS && culprit().row == 0);
    /* The last solution is still there. */
    CHECK(stiction_is_usable(s, 0) && stiction_read(s, &solution) == STICTION_OK && solution.count == 1);
}

/* Is this the speed at which it still falls? */
static bool falls(double speed)
{
    return solve(-2, 0, 1000) == STICTION_SOLVED && stiction_read(s, &solution) == STICTION_OK && near(solution.velocity[0], -speed);
}

/* What a mechanic measures of a point that slides while the floor has no friction, and then has some. */
static void violations(void)
{
#if STICTION_D > 1 && STICTION_D <= 3
    stiction_violation worst;
    point(0);
    CHECK(solve(-2, 3, 1000) == STICTION_SOLVED && stiction_worst_violation(s, &worst) == STICTION_OK);
    CHECK(near(worst.missing_friction, 0) && near(worst.creep, 0) && stiction_set_friction(s, 0, (stiction_real)0.5) == STICTION_OK);
    CHECK(stiction_worst_violation(s, &worst) == STICTION_OK && near(worst.missing_friction, 1) && near(worst.creep, 0));
    CHECK(stiction_set_friction(s, 0, 2) == STICTION_OK && stiction_worst_violation(s, &worst) == STICTION_OK);
    CHECK(near(worst.missing_friction, 0) && near(worst.creep, 1.5)); /* 4 N s could stop 3 */
    CHECK(near(worst.opening_impulse, 0) && near(worst.row_impulse, 0) && near(worst.row_speed, 0));
#endif
}

/* The relaxation opens by half of the speed: 2 u_N = -2 + r, 2 u_T = 3 - r / 2. */
static void relaxation(void)
{
    CHECK(stiction_set_model(s, (enum stiction_model)2) == STICTION_INVALID_MODEL && culprit().input == STICTION_INPUT_NONE);
    char text[80] = "";
    CHECK(stiction_describe(s, text, sizeof text) == STICTION_OK && strcmp(text, "a number that is no law of contacts") == 0);
    if (STICTION_D == 1) return;
    stiction_violation worst;
    point(0.5);
    CHECK(stiction_set_model(s, STICTION_CONVEX_RELAXATION) == STICTION_OK && solve(-2, 3, 1000) == STICTION_SOLVED);
    CHECK(stiction_read(s, &solution) == STICTION_OK && near(solution.contacts[0].impulse[0], 2.8));
    CHECK(near(solution.velocity[0], 0.4) && near(solution.velocity[1], 0.8));
    CHECK(stiction_worst_violation(s, &worst) == STICTION_OK && near(worst.missing_friction, 0) && near(worst.opening_impulse, 0.8));
    CHECK(stiction_set_model(s, STICTION_COULOMB) == STICTION_OK && solve(-2, 3, 1000) == STICTION_SOLVED);
    CHECK(stiction_read(s, &solution) == STICTION_OK && near(solution.contacts[0].impulse[0], 2));
}

/* Two contacts at one point share 2 N s, pushed along by half of what their friction bears. */
static void loads(void)
{
    if (STICTION_C < 2 || STICTION_D == 1) return;
    const stiction_real accuracy = (stiction_real)0.001;
    stiction_real share = 0;
    point(0.5);
    CHECK(add(h, offset, 0.5, 43) == STICTION_OK);
    CHECK(stiction_slip_reserve(s, accuracy, &share) == STICTION_STALE_FACTOR && share == 0);
    CHECK(solve(-2, 0.5, 1000) == STICTION_SOLVED);
    CHECK(stiction_read_least(s, TOLERANCE, &solution) == STICTION_OK && near(solution.error, 0));
    CHECK(near(solution.contacts[0].impulse[0], 1) && near(solution.contacts[1].impulse[0], 1));
    CHECK(near(solution.contacts[0].impulse[1], -0.25) && near(solution.contacts[1].impulse[1], -0.25));
    CHECK(stiction_slip_reserve(s, accuracy, &share) == STICTION_OK && fabs((double)share - 0.5) < 0.001);
    CHECK(stiction_rest_reserve(s, free_impulse, accuracy, &share) == STICTION_OK && fabs((double)share - 0.5) < 0.001);
    stiction_real push[STICTION_N] = {0, 1};
    CHECK(stiction_load_reserve(s, push, accuracy, &share) == STICTION_OK && fabs((double)share - 0.5) < 0.001);
    push[0] = -1, push[1] = 0;
    CHECK(stiction_load_reserve(s, push, accuracy, &share) == STICTION_OK && isinf(share));
    push[0] = NAN;
    CHECK(stiction_load_reserve(s, push, accuracy, &share) == STICTION_NOT_FINITE && isinf(share));
    CHECK(stiction_read_least(s, NAN, &solution) == STICTION_INVALID_TOLERANCE);
    /* It slides at 0.25 m/s, which is still where that is said. */
    CHECK(solve(-2, 1.5, 1000) == STICTION_SOLVED && stiction_read(s, &solution) == STICTION_OK);
    CHECK(solution.contacts[0].mode == STICTION_SLIP && stiction_set_still(s, (stiction_real)0.3) == STICTION_OK);
    CHECK(solve(-2, 1.5, 1000) == STICTION_SOLVED && stiction_read(s, &solution) == STICTION_OK);
    CHECK(solution.contacts[0].mode == STICTION_STICK && stiction_set_still(s, -1) == STICTION_OK);
    CHECK(solve(-2, 1.5, 1000) == STICTION_INVALID_TOLERANCE && stiction_set_still(s, 0) == STICTION_OK);
}

/* A bit flips in a number of the factor: of masses of 2 kg there are halves all over. What comes is not called solved if it is wrong, and
   the tick after that is right again, with the same data. */
static void flips(void)
{
    const stiction_real half = (stiction_real)0.5;
    unsigned char *const bytes = (unsigned char *)s->memory;
    int halves = 0, unsolved = 0;
    for (size_t at = 0; at + sizeof half <= sizeof s->memory; at += sizeof half) {
        for (size_t bit = 0; bit < 8 * sizeof half; bit++) {
            CHECK(stiction_init(s) == STICTION_OK && set_mass() == STICTION_OK && add(h, offset, 0.75, 42) == STICTION_OK);
            CHECK(solve(-2, 0.25, 1000) == STICTION_SOLVED);
            if (memcmp(bytes + at, &half, sizeof half) != 0) break;
            halves += bit == 0;
            bytes[at + bit / 8] ^= (unsigned char)(1u << bit % 8);
            bool was_solved = true;
            for (int tick = 0; tick < 4; tick++) {
                CHECK(set_mass() == STICTION_OK && stiction_clear(s) == STICTION_OK && add(h, offset, 0.75, 42) == STICTION_OK);
                enum stiction_status status = solve(-2, 0.25 * tick, 1000);
                const bool is_solved = status == STICTION_SOLVED;
                CHECK(status > 0 && (is_solved || was_solved));
                unsolved += !is_solved;
                was_solved = is_solved;
                if (!is_solved) continue;
                CHECK(stiction_read(s, &solution) == STICTION_OK && near(solution.contacts[0].impulse[0], 2));
                CHECK(near(solution.velocity[0], 0) && (STICTION_D == 1 || near(solution.velocity[1], 0)));
            }
        }
    }
    CHECK(halves > STICTION_N && unsolved > 0);
    CHECK(stiction_init(s) == STICTION_OK);
}

/* Contacts by index and key, their surfaces, impulses to start at. */
static void one_by_one(void)
{
    stiction_contact found = {.key = 99};
    stiction_violation worst;
    point(0.5);
    CHECK(stiction_reset(s) == STICTION_OK && solve(-2, 0, 0) == STICTION_OUT_OF_BUDGET);
    CHECK(stiction_worst_violation(s, &worst) == STICTION_OK && near(worst.closing_speed, 1) && near(worst.outside_cone, 0));
    CHECK(solve(-2, 0, 1000) == STICTION_SOLVED);
    CHECK(stiction_worst_violation(s, &worst) == STICTION_OK && near(worst.closing_speed, 0) && near(worst.outside_cone, 0));
    CHECK(stiction_contact_by_key(s, 41, &found) == STICTION_NO_SUCH_KEY && found.key == 99);
    CHECK(stiction_contact_at(s, 1, &found) == STICTION_NO_SUCH_CONTACT && found.key == 99);
    CHECK(stiction_contact_by_key(s, 42, &found) == STICTION_OK && found.key == 42 && near(found.impulse[0], 2));
    found.impulse[0] = 0;
    CHECK(stiction_contact_at(s, 0, &found) == STICTION_OK && found.key == 42 && near(found.impulse[0], 2));

    /* These impulses are the solution. */
    const stiction_contact_impulse known = {.key = 42, .impulse = {2}};
    CHECK(stiction_reset(s) == STICTION_OK && stiction_set_impulses(s, &known, 1, NULL, 0) == STICTION_OK);
    CHECK(solve(-2, 0, 1000) == STICTION_SOLVED && stiction_read(s, &solution) == STICTION_OK && solution.work == 0);

    if (STICTION_S == 0) return;
    /* A sole that gives way by 0.5 m/s an N s: 2 v = -2 + r, v + r / 2 = 0. */
    const stiction_surface soft = {.friction = {1, 1}, .compliance = {(stiction_real)0.5, 0}};
    CHECK(stiction_contact_index(s, 42) == 0 && stiction_remove_contact(s, 0) == STICTION_OK);
    CHECK(stiction_add_contact_on(s, h, offset, &soft, 3) == STICTION_OK);
    CHECK(solve(-2, 0, 1000) == STICTION_SOLVED && stiction_contact_by_key(s, 3, &found) == STICTION_OK);
    CHECK(near(found.impulse[0], 1) && stiction_read(s, &solution) == STICTION_OK && near(solution.velocity[0], -0.5));
    if (STICTION_D >= 3) { /* a track: grips along, slips across */
        const stiction_surface track = {.friction = {1, (stiction_real)0.25}};
        CHECK(stiction_clear_contacts(s) == STICTION_OK && stiction_add_contact_on(s, h, offset, &track, 3) == STICTION_OK);
        CHECK(solve(-2, 1, 1000) == STICTION_SOLVED && stiction_contact_at(s, 0, &found) == STICTION_OK);
        CHECK(found.mode == STICTION_STICK && near(found.impulse[1], -1));
        free_impulse[2] = 1;
        CHECK(solve(-2, 0, 1000) == STICTION_SOLVED && stiction_contact_at(s, 0, &found) == STICTION_OK);
        CHECK(found.mode == STICTION_SLIP && near(found.impulse[2], -0.5));
        free_impulse[2] = 0;
    }
    if (STICTION_S < STICTION_C) { /* a rigid contact behind all the soles that there is room for */
        CHECK(stiction_clear_contacts(s) == STICTION_OK);
        for (int i = 0; i < STICTION_S; i++) CHECK(stiction_add_contact_on(s, h, offset, &soft, 3) == STICTION_OK);
        CHECK(add(h, offset, 1, 4) == STICTION_OK && falls(0));
        CHECK(stiction_contact_index(s, 4) == STICTION_S && stiction_remove_contact(s, STICTION_S) == STICTION_OK);
        CHECK(falls(1 / (1.0 + STICTION_S))); /* the others are still soft */
        CHECK(stiction_contact_index(s, 4) == STICTION_NO_SUCH_KEY && stiction_contact_index(s, 3) == 0);
        CHECK(add(h, offset, 1, 4) == STICTION_OK && stiction_remove_contact(s, 0) == STICTION_OK && falls(0));
        CHECK(stiction_contact_at(s, STICTION_S - 1, &found) == STICTION_OK && found.key == 4 && near(found.impulse[0], 2));
    }
}

/* A solve in pieces comes to the same bits as in one call. */
static void pieces(void)
{
    point(0.5);
    CHECK(stiction_reset(s) == STICTION_OK && solve(-2, 3, 1000) == STICTION_SOLVED);
    static stiction_solution whole;
    CHECK(stiction_read(s, &whole) == STICTION_OK && stiction_reset(s) == STICTION_OK);
    if (whole.work > 2) {
        CHECK(stiction_advance(s, free_impulse, TOLERANCE, 1) == STICTION_UNSOLVED && !stiction_is_usable(s, 1));
        CHECK(stiction_resume(s, free_impulse, TOLERANCE, 0) >= 0); /* the best so far */
    }
    int calls = 1;
    while (stiction_advance(s, free_impulse, TOLERANCE, 0) == STICTION_UNSOLVED) CHECK(++calls < 1000);
    CHECK(stiction_is_usable(s, 0) && stiction_reset(s) == STICTION_OK);
    while (stiction_advance(s, free_impulse, TOLERANCE, 1) == STICTION_UNSOLVED) CHECK(++calls < 1000);
    CHECK(stiction_is_usable(s, 0) && stiction_read(s, &solution) == STICTION_OK && solution.work == whole.work);
    CHECK(memcmp(solution.velocity, whole.velocity, sizeof whole.velocity) == 0);
    CHECK(memcmp(solution.contacts[0].impulse, whole.contacts[0].impulse, sizeof whole.contacts[0].impulse) == 0);
    free_impulse[1] = NAN;
    CHECK(stiction_advance(s, free_impulse, 1, 1) == STICTION_NOT_FINITE && culprit().row == 1);
    free_impulse[1] = 0;
}

#endif

/* More time is more budget, and none is none. */
static void budgets(void)
{
    const uint32_t one = stiction_budget_within(100000, 168, 0), ten = stiction_budget_within(1000000, 168, 0);
    CHECK(stiction_budget_within(0, 168, 0) == 0 && stiction_budget_within(1000, 0, 0) == 0);
    CHECK(sizeof(stiction_real) == 4 ? one > 0 && ten > 9 * one : ten == 0);
    CHECK(stiction_budget_within(UINT32_MAX, UINT32_MAX, 0) >= ten && stiction_budget_within(1000000, 168, 55) <= ten);
}

static stiction_row row_at(uint32_t place)
{
    stiction_row row;
    CHECK(stiction_row_at(s, place, &row) == STICTION_OK);
    return row;
}

enum { JOINT = STICTION_N - 1 };

static enum stiction_status turn(double impulse)
{
    memset(free_impulse, 0, sizeof free_impulse);
    free_impulse[JOINT] = (stiction_real)impulse;
    enum stiction_status status = stiction_solve(s, free_impulse, TOLERANCE, 1000);
    CHECK(status < 0 || stiction_read(s, &solution) == STICTION_OK);
    free_impulse[JOINT] = 0;
    return status;
}

/* Does the joint turn with this velocity, and the row take this impulse? */
static bool turns(double velocity, double impulse, enum stiction_row_mode mode)
{
    const stiction_row row = row_at(0);
    return near(solution.velocity[JOINT], velocity) && near(row.impulse, impulse) && row.mode == mode;
}

/* Joint rows on paper, at a joint of 2 kg m^2: 2 v = free + impulse. */
static void joint_rows(void)
{
    stiction_joint_row row = {.row = {[JOINT] = 1}, .key = 7};
    stiction_row found = {.key = 99};
    nothing_there();
    CHECK(stiction_row_by_key(s, 7, &found) == STICTION_NO_SUCH_KEY && found.key == 99);
    CHECK(stiction_row_at(s, 0, &found) == STICTION_NO_SUCH_ROW && found.key == 99);
    if (STICTION_R == 0) {
        CHECK(stiction_add_row(s, &row) == STICTION_ROW_LIST_FULL && culprit().joint_row == 0 && culprit().contact == -1);
        return;
    }
    /* A stop: reached, left, and half a radian a second away. */
    CHECK(stiction_add_row(s, &row) == STICTION_OK);
    stiction_violation worst;
    memset(free_impulse, 0, sizeof free_impulse);
    free_impulse[JOINT] = -6;
    CHECK(stiction_reset(s) == STICTION_OK);
    CHECK(stiction_solve(s, free_impulse, TOLERANCE, 0) == STICTION_OUT_OF_BUDGET);
    CHECK(stiction_worst_violation(s, &worst) == STICTION_OK && near(worst.row_speed, 3));
    CHECK(turn(-6) == STICTION_SOLVED && turns(0, 6, STICTION_ROW_AT_LIMIT));
    CHECK(stiction_worst_violation(s, &worst) == STICTION_OK && near(worst.row_speed, 0) && near(worst.row_impulse, 0));
    CHECK(stiction_row_by_key(s, 7, &found) == STICTION_OK && found.key == 7 && near(found.impulse, 6));
    CHECK(near(found.velocity, 0) && found.certificate == 0);
    CHECK(turn(6) == STICTION_SOLVED && turns(3, 0, STICTION_ROW_OPEN) && near(row_at(0).velocity, 3));
    CHECK(stiction_set_row_offset(s, 0, (stiction_real)0.5) == STICTION_OK);
    CHECK(turn(-6) == STICTION_SOLVED && turns(-0.5, 5, STICTION_ROW_AT_LIMIT));
#if STICTION_R > 0
    CHECK(solution.row_count == 1 && solution.rows[0].key == 7 && near(solution.rows[0].impulse, 5));
    CHECK(solution.rows[STICTION_R - 1].key == (STICTION_R > 1 ? 0 : 7));
#endif
    /* The stop on the other side. */
    stiction_real jacobian_row[STICTION_N] = {[JOINT] = -1};
    CHECK(stiction_set_row_jacobian(s, 0, jacobian_row) == STICTION_OK);
    CHECK(turn(6) == STICTION_SOLVED && turns(0.5, 5, STICTION_ROW_AT_LIMIT));
    /* A drive that turns it with 3 rad/s, whatever that takes; one that gives way by half a radian a second an N m s. */
    jacobian_row[JOINT] = 1;
    CHECK(stiction_set_row_jacobian(s, 0, jacobian_row) == STICTION_OK && stiction_set_row_offset(s, 0, -3) == STICTION_OK);
    CHECK(stiction_set_row_law(s, 0, STICTION_EQUALITY, 0, 0) == STICTION_OK);
    CHECK(turn(1) == STICTION_SOLVED && turns(3, 5, STICTION_ROW_HOLDING));
    CHECK(stiction_set_row_offset(s, 0, 0) == STICTION_OK);
    CHECK(stiction_set_row_compliance(s, 0, (stiction_real)0.5) == STICTION_OK);
    CHECK(turn(6) == STICTION_SOLVED && turns(1.5, -3, STICTION_ROW_HOLDING) && near(row_at(0).velocity, 0));
    /* Dry friction of 1 N m s. */
    CHECK(stiction_set_row_compliance(s, 0, 0) == STICTION_OK && stiction_set_row_law(s, 0, STICTION_BOX, -1, 1) == STICTION_OK);
    CHECK(turn(6) == STICTION_SOLVED && turns(2.5, -1, STICTION_ROW_AT_LOWER));
    CHECK(stiction_set_row_law(s, 0, STICTION_BOX, -3, 1) == STICTION_OK); /* and of 3, which does not act yet */
    CHECK(stiction_worst_violation(s, &worst) == STICTION_OK && near(worst.row_impulse, 2));
    CHECK(stiction_set_row_law(s, 0, STICTION_BOX, -1, 1) == STICTION_OK);
    CHECK(turn(0.5) == STICTION_SOLVED && turns(0, -0.5, STICTION_ROW_HOLDING));
    CHECK(turn(-6) == STICTION_SOLVED && turns(-2.5, 1, STICTION_ROW_AT_UPPER));
    /* These impulses are the solution. */
    const stiction_row_impulse known = {.key = 7, .impulse = 1};
    CHECK(stiction_reset(s) == STICTION_OK && stiction_set_impulses(s, NULL, 0, &known, 1) == STICTION_OK);
    CHECK(turn(-6) == STICTION_SOLVED && turns(-2.5, 1, STICTION_ROW_AT_UPPER) && solution.work == 0);
    /* All at once in a row, and removed in two ways. */
    CHECK(stiction_row_index(s, 7) == 0 && stiction_remove_row(s, 0) == STICTION_OK && turn(6) == STICTION_SOLVED && near(solution.velocity[JOINT], 3));
    row = (stiction_joint_row){{[JOINT] = 2}, 1, STICTION_BOX, -1, 4, (stiction_real)0.5, 8};
    CHECK(stiction_add_row(s, &row) == STICTION_OK); /* 2 v = -6 + 2 l, 2 v + 1 + l / 2 = 0: l = 2, v = -1 */
    CHECK(turn(-6) == STICTION_SOLVED && turns(-1, 2, STICTION_ROW_HOLDING) && row_at(0).key == 8);
    CHECK(stiction_clear_rows(s) == STICTION_OK && turn(-6) == STICTION_SOLVED && near(solution.velocity[JOINT], -3));
    if (STICTION_R > 1) { /* two drives that contradict each other */
        row = (stiction_joint_row){.row = {[JOINT] = 1}, .law = STICTION_EQUALITY, .key = 1};
        CHECK(stiction_add_row(s, &row) == STICTION_OK);
        row = (stiction_joint_row){.row = {[JOINT] = 1}, .law = STICTION_EQUALITY, .offset = 1, .key = 2};
        CHECK(stiction_add_row(s, &row) == STICTION_OK && turn(1) == INFEASIBLE && !stiction_is_usable(s, (stiction_real)0.1));
        CHECK(stiction_row_by_key(s, 2, &found) == STICTION_OK);
        CHECK((found.certificate != 0 && row_at(0).certificate != 0) == PROVES);
        CHECK(stiction_reset(s) == STICTION_OK);
    }
#if STICTION_C > 0
    if (STICTION_N > STICTION_D) { /* beside a contact, of which it knows nothing */
        point(0.5);
        row = (stiction_joint_row){.row = {[JOINT] = 1}, .key = 42};
        CHECK(stiction_add_row(s, &row) == STICTION_OK);
        CHECK(turn(-6) == STICTION_SOLVED && turns(0, 6, STICTION_ROW_AT_LIMIT) && solution.count == 1);
        CHECK(stiction_clear_contacts(s) == STICTION_OK && turn(-6) == STICTION_SOLVED && solution.count == 0);
        CHECK(turns(0, 6, STICTION_ROW_AT_LIMIT));
    }
#endif
}

/* Both stops of a joint of 2 kg m^2, beside the scene: the lower one is reached, the upper one 10 rad/s away. */
static void limits(void)
{
    stiction_joint_row stops[STICTION_L + 2] = {{.row = {[JOINT] = 1}, .key = 1}, {.row = {[JOINT] = -1}, .offset = 10, .key = 2}};
    nothing_there();
    memset(free_impulse, 0, sizeof free_impulse);
    free_impulse[JOINT] = -6;
    const stiction_real tolerance = TOLERANCE;
    CHECK(stiction_solve_with_limits(s, NULL, 0, free_impulse, tolerance, 1000) == STICTION_SOLVED);
    CHECK(stiction_read(s, &solution) == STICTION_OK && near(solution.velocity[JOINT], -3));
    CHECK(stiction_solve_with_limits(s, NULL, 1, free_impulse, tolerance, 1000) == STICTION_NULL);
    CHECK(stiction_solve_with_limits(s, stops, STICTION_L + 1, free_impulse, tolerance, 1000) == STICTION_LIMIT_LIST_FULL);
    CHECK(culprit().input == STICTION_INPUT_LIMIT && culprit().joint_row == STICTION_L);
    char text[80] = "";
    CHECK(stiction_describe(s, text, sizeof text) == STICTION_OK && strncmp(text, "limits are full (room for ", 26) == 0);
    if (STICTION_L < 2 || STICTION_R == 0) return;
    stiction_row found = {.key = 99};
    CHECK(stiction_solve_with_limits(s, stops, 2, free_impulse, tolerance, 0) == STICTION_OUT_OF_BUDGET);
    CHECK(stiction_resume(s, free_impulse, tolerance, 1000) == STICTION_LIMITS_LEFT_OUT);
    CHECK(stiction_resume_with_limits(s, stops, 2, free_impulse, tolerance, 1000) == STICTION_SOLVED);
    CHECK(stiction_read(s, &solution) == STICTION_OK && near(solution.velocity[JOINT], 0));
    int calls = 1; /* the same in pieces */
    CHECK(stiction_reset(s) == STICTION_OK);
    while (stiction_advance_with_limits(s, stops, 2, free_impulse, tolerance, 1) == STICTION_UNSOLVED) CHECK(++calls < 1000);
    CHECK(stiction_is_usable(s, 0));
    CHECK(stiction_read(s, &solution) == STICTION_OK && near(solution.velocity[JOINT], 0));
    CHECK(stiction_row_by_key(s, 1, &found) == STICTION_OK && found.mode == STICTION_ROW_AT_LIMIT && near(found.impulse, 6));
    CHECK(stiction_row_by_key(s, 2, &found) == STICTION_NO_SUCH_KEY);
    free_impulse[JOINT] = 26; /* onto the other one */
    CHECK(stiction_solve_with_limits(s, stops, 2, free_impulse, tolerance, 1000) == STICTION_SOLVED);
    CHECK(stiction_row_by_key(s, 2, &found) == STICTION_OK && near(found.impulse, 6));
    stops[1].law = (enum stiction_law)3;
    CHECK(stiction_solve_with_limits(s, stops, 2, free_impulse, tolerance, 1000) == STICTION_INVALID_LAW);
    stops[1].law = STICTION_LIMIT;
    stops[1].compliance = -1;
    CHECK(stiction_solve_with_limits(s, stops, 2, free_impulse, tolerance, 1000) == STICTION_INVALID_LIMIT);
    CHECK(culprit().input == STICTION_INPUT_LIMIT && culprit().joint_row == 1 && culprit().row == -1);
    stops[1].compliance = 0;
    stops[1].offset = NAN;
    CHECK(stiction_solve_with_limits(s, stops, 2, free_impulse, tolerance, 1000) == STICTION_NOT_FINITE);
    CHECK(culprit().input == STICTION_INPUT_LIMIT && culprit().joint_row == 1 && culprit().row == STICTION_N);
    free_impulse[JOINT] = 0;
    CHECK(stiction_reset(s) == STICTION_OK && turn(-6) == STICTION_SOLVED && near(solution.velocity[JOINT], -3)); /* none is in the scene */
}

/* What is refused of joint rows, and what it is about. */
static void refused_rows(void)
{
    const stiction_joint_row good = {.row = {[JOINT] = 1}, .key = 7};
    stiction_joint_row row = good;
    nothing_there();
    row.law = (enum stiction_law)3;
    char text[80] = "";
    for (int call = 0; call < 2; call++) {
        CHECK(stiction_remove_row(s, 5) == STICTION_NO_SUCH_ROW && culprit().joint_row == 5);
        CHECK((call ? stiction_set_row_law(s, 0, row.law, 0, 0) : stiction_add_row(s, &row)) == STICTION_INVALID_LAW);
        CHECK(culprit().input == STICTION_INPUT_NONE && culprit().joint_row == -1);
        CHECK(stiction_describe(s, text, sizeof text) == STICTION_OK);
        CHECK(strcmp(text, "a number that is no law of a joint row") == 0);
    }
    row = good;
    row.row[1] = NAN;
    CHECK(stiction_add_row(s, &row) == STICTION_NOT_FINITE && culprit().input == STICTION_INPUT_JOINT_ROW);
    CHECK(culprit().joint_row == 0 && culprit().contact == -1 && culprit().row == 1 && culprit().column == 0);
    row = good;
    row.offset = NAN;
    CHECK(stiction_add_row(s, &row) == STICTION_NOT_FINITE && culprit().joint_row == 0 && culprit().row == STICTION_N);
    row = good;
    row.compliance = -1;
    CHECK(stiction_add_row(s, &row) == STICTION_INVALID_ROW_COMPLIANCE && culprit().input == STICTION_INPUT_COMPLIANCE);
    CHECK(culprit().joint_row == 0);
    row = (stiction_joint_row){.law = STICTION_BOX, .lower = 1, .upper = -1};
    CHECK(stiction_add_row(s, &row) == STICTION_INVALID_BOUNDS && culprit().input == STICTION_INPUT_BOUNDS);
    CHECK(culprit().joint_row == 0);
    CHECK(turn(1) == STICTION_SCENE_INCOMPLETE && culprit().input == STICTION_INPUT_JOINT_ROW);
    CHECK(stiction_clear_rows(s) == STICTION_OK && turn(2) == STICTION_SOLVED);
    for (int i = 0; i < STICTION_R; i++) CHECK(stiction_add_row(s, &good) == STICTION_OK);
    CHECK(stiction_add_row(s, &good) == STICTION_ROW_LIST_FULL && culprit().joint_row == STICTION_R && culprit().key == -1);
    CHECK(stiction_set_row_offset(s, STICTION_R, 0) == STICTION_NO_SUCH_ROW && culprit().joint_row == STICTION_R);
    CHECK(stiction_set_row_jacobian(s, STICTION_R, good.row) == STICTION_NO_SUCH_ROW);
    CHECK(stiction_set_row_law(s, STICTION_R, STICTION_LIMIT, 0, 0) == STICTION_NO_SUCH_ROW);
    CHECK(stiction_set_row_compliance(s, STICTION_R, 0) == STICTION_NO_SUCH_ROW);
    CHECK(stiction_remove_row(s, STICTION_R) == STICTION_NO_SUCH_ROW && culprit().joint_row == STICTION_R && culprit().key == -1);
    CHECK(stiction_row_index(s, 8) == STICTION_NO_SUCH_KEY);
    stiction_row_impulse impulses[STICTION_R + 1] = {{.key = 7}};
    CHECK(stiction_set_impulses(s, NULL, 0, impulses, STICTION_R + 1) == STICTION_IMPULSE_LIST_FULL);
    CHECK(culprit().input == STICTION_INPUT_INITIAL_ROW_IMPULSE && culprit().joint_row == STICTION_R);
    if (STICTION_R > 0) {
        impulses[0].impulse = INFINITY;
        CHECK(stiction_set_impulses(s, NULL, 0, impulses, 1) == STICTION_NOT_FINITE);
        CHECK(culprit().input == STICTION_INPUT_INITIAL_ROW_IMPULSE && culprit().joint_row == 0);
        CHECK(stiction_set_row_offset(s, 0, NAN) == STICTION_NOT_FINITE && culprit().input == STICTION_INPUT_JOINT_ROW);
        stiction_real tiny = 1; /* its square vanishes */
        while (tiny * tiny > 0) tiny /= 2;
        const stiction_real jacobian_row[STICTION_N] = {tiny};
        CHECK(stiction_clear_rows(s) == STICTION_OK && stiction_add_row(s, &good) == STICTION_OK);
        CHECK(stiction_set_row_jacobian(s, 0, jacobian_row) == STICTION_OK && turn(1) == STICTION_ROW_OUT_OF_RANGE);
        CHECK(culprit().input == STICTION_INPUT_JOINT_ROW && culprit().key == 7 && culprit().joint_row == -1);
    }
}

/* Helpers on paper: a gap of 2 mm, and a point of a body over a floor. */
static void helpers(void)
{
    stiction_real w = 99;
    CHECK(stiction_gap_offset((stiction_real)2e-3, 1, INFINITY, (stiction_real)1e-3, &w) == STICTION_OK && near(w, 2));
    CHECK(stiction_gap_offset((stiction_real)-2e-3, 1, INFINITY, (stiction_real)1e-3, &w) == STICTION_OK && near(w, -1));
    CHECK(stiction_gap_offset(INFINITY, 1, 3, (stiction_real)1e-3, &w) == STICTION_OK && near(w, 3));
    CHECK(stiction_gap_offset(1, 1, 3, 0, &w) == STICTION_INVALID_PARAMETER && stiction_gap_offset(NAN, 1, 3, 1, &w) < 0 && near(w, 3));
    CHECK(stiction_gap_offset(1, 1, 3, 1, NULL) == STICTION_NULL);

    /* The last axis is up. */
    enum { UP = STICTION_K - 1 };
    stiction_real normal[STICTION_K] = {[UP] = 1}, frame[STICTION_K][STICTION_K] = {{99}};
    static stiction_real point[STICTION_K][STICTION_N], turning[STICTION_K][STICTION_N], rows[STICTION_D][STICTION_N];
    CHECK(stiction_contact_frame(normal, frame) == STICTION_OK && frame[0][UP] == 1 && frame[0][0] == 0);
    for (int k = 1; k < STICTION_K; k++)
        for (int i = 0; i < STICTION_K; i++) CHECK(frame[k][i] == (i == k - 1));
    for (int k = 0; k < STICTION_K; k++) point[k][k] = 1, turning[k][k] = 2;
    CHECK(stiction_contact_rows(normal, STICTION_CONST(point), STICTION_CONST(turning), rows) == STICTION_OK);
    for (int k = 0; k < STICTION_D; k++) { /* normal and tangents of the point, then the same of what turns */
        const int axis = k % STICTION_K, moves = axis == 0 ? UP : axis - 1;
        for (int i = 0; i < STICTION_N; i++) CHECK(rows[k][i] == (i == moves ? k < STICTION_K ? 1 : 2 : 0));
    }
    rows[0][0] = 99;
    CHECK(stiction_contact_rows(normal, STICTION_CONST(point), NULL, rows) == (STICTION_D > 3 ? STICTION_NULL : STICTION_OK));
    normal[UP] = 2;
    rows[0][0] = 99;
    CHECK(stiction_contact_frame(normal, frame) == STICTION_INVALID_PARAMETER && frame[0][UP] == 1);
    CHECK(stiction_contact_rows(normal, STICTION_CONST(point), STICTION_CONST(turning), rows) == STICTION_INVALID_PARAMETER && rows[0][0] == 99);
    CHECK(stiction_contact_frame(NULL, frame) == STICTION_NULL && stiction_contact_frame(normal, NULL) == STICTION_NULL);
    CHECK(stiction_contact_rows(NULL, STICTION_CONST(point), NULL, rows) == STICTION_NULL);
    CHECK(stiction_contact_rows(normal, NULL, NULL, rows) == STICTION_NULL);
    CHECK(stiction_contact_rows(normal, STICTION_CONST(point), STICTION_CONST(turning), NULL) == STICTION_NULL);
}

static void nothing(stiction *none, enum stiction_status status)
{
    char text[8];
    stiction_real share;
    stiction_culprit culprit;
    stiction_contact contact;
    stiction_row row;
    stiction_violation violation;
    const stiction_joint_row joint_row = {.key = 1};
    const stiction_surface surface = {.spin = 0};
    const stiction_contact_impulse contact_impulse = {.key = 1};
    const stiction_row_impulse row_impulse = {.key = 1};
    CHECK(stiction_set_velocities(none, 3) == status && stiction_set_model(none, STICTION_COULOMB) == status);
    CHECK(stiction_reset(none) == status && stiction_set_mass(none, STICTION_CONST(mass)) == status);
    CHECK(stiction_clear(none) == status && stiction_clear_contacts(none) == status && stiction_clear_rows(none) == status);
#if STICTION_D <= 3
    CHECK(stiction_add_contact(none, STICTION_CONST(jacobian), offset, 1, 0) == status);
#endif
    CHECK(stiction_add_contact_on(none, STICTION_CONST(jacobian), offset, &surface, 0) == status);
    CHECK(stiction_set_jacobian(none, 0, STICTION_CONST(jacobian)) == status && stiction_set_offset(none, 0, offset) == status);
    CHECK(stiction_set_friction(none, 0, 1) == status && stiction_remove_contact(none, 0) == status);
    CHECK(stiction_add_row(none, &joint_row) == status && stiction_remove_row(none, 0) == status);
    CHECK(stiction_set_row_jacobian(none, 0, mass[0]) == status && stiction_set_row_offset(none, 0, 0) == status);
    CHECK(stiction_set_row_law(none, 0, STICTION_LIMIT, 0, 0) == status && stiction_set_row_compliance(none, 0, 0) == status);
    CHECK(stiction_set_impulses(none, &contact_impulse, 1, &row_impulse, 1) == status);
    CHECK(stiction_solve(none, free_impulse, 1, 9) == status && stiction_resume(none, free_impulse, 1, 9) == status);
    CHECK(stiction_advance(none, free_impulse, 1, 9) == status);
    CHECK(stiction_solve_with_limits(none, &joint_row, 1, free_impulse, 1, 9) == status);
    CHECK(stiction_resume_with_limits(none, &joint_row, 1, free_impulse, 1, 9) == status);
    CHECK(stiction_advance_with_limits(none, &joint_row, 1, free_impulse, 1, 9) == status);
    CHECK(!stiction_is_usable(none, 1) && stiction_read(none, &solution) == status);
    CHECK(stiction_set_still(none, 0) == status && stiction_read_least(none, 1, &solution) == status);
    CHECK(stiction_slip_reserve(none, 1, &share) == status && stiction_load_reserve(none, free_impulse, 1, &share) == status);
    CHECK(stiction_rest_reserve(none, free_impulse, 1, &share) == status);
    CHECK(stiction_contact_at(none, 0, &contact) == status && stiction_contact_by_key(none, 0, &contact) == status);
    CHECK(stiction_row_at(none, 0, &row) == status && stiction_row_by_key(none, 0, &row) == status);
    CHECK(stiction_contact_index(none, 0) == status && stiction_row_index(none, 0) == status);
    CHECK(stiction_worst_violation(none, &violation) == status && stiction_last_culprit(none, &culprit) == status);
    CHECK(stiction_describe(none, text, sizeof text) == status);
}

static void nulls(void)
{
    stiction_real share;
    const stiction_surface surface = {.spin = 0};
    nothing(NULL, STICTION_NULL);
    CHECK(stiction_init(NULL) == STICTION_NULL && stiction_set_mass(s, NULL) == STICTION_NULL);
#if STICTION_D <= 3
    CHECK(stiction_add_contact(s, NULL, offset, 1, 0) == STICTION_NULL);
    CHECK(stiction_add_contact(s, STICTION_CONST(jacobian), NULL, 1, 0) == STICTION_NULL);
#endif
    CHECK(stiction_add_contact_on(s, NULL, offset, &surface, 0) == STICTION_NULL);
    CHECK(stiction_add_contact_on(s, STICTION_CONST(jacobian), NULL, &surface, 0) == STICTION_NULL);
    CHECK(stiction_add_contact_on(s, STICTION_CONST(jacobian), offset, NULL, 0) == STICTION_NULL);
    CHECK(stiction_set_jacobian(s, 0, NULL) == STICTION_NULL && stiction_set_offset(s, 0, NULL) == STICTION_NULL);
    CHECK(stiction_add_row(s, NULL) == STICTION_NULL && stiction_set_row_jacobian(s, 0, NULL) == STICTION_NULL);
    CHECK(stiction_set_impulses(s, NULL, 1, NULL, 0) == STICTION_NULL);
    CHECK(stiction_set_impulses(s, NULL, 0, NULL, 1) == STICTION_NULL);
    CHECK(stiction_set_impulses(s, NULL, 0, NULL, 0) == STICTION_OK);
    CHECK(stiction_solve(s, NULL, 1, 9) == STICTION_NULL && stiction_resume(s, NULL, 1, 9) == STICTION_NULL);
    CHECK(stiction_advance(s, NULL, 1, 9) == STICTION_NULL && stiction_solve_with_limits(s, NULL, 0, NULL, 1, 9) == STICTION_NULL);
    CHECK(stiction_resume_with_limits(s, NULL, 1, free_impulse, 1, 9) == STICTION_NULL);
    CHECK(stiction_advance_with_limits(s, NULL, 1, free_impulse, 1, 9) == STICTION_NULL);
    CHECK(stiction_contact_at(s, 0, NULL) == STICTION_NULL && stiction_contact_by_key(s, 0, NULL) == STICTION_NULL);
    CHECK(stiction_row_at(s, 0, NULL) == STICTION_NULL && stiction_row_by_key(s, 0, NULL) == STICTION_NULL);
    CHECK(stiction_read_least(s, 1, NULL) == STICTION_NULL && stiction_slip_reserve(s, 1, NULL) == STICTION_NULL);
    CHECK(stiction_load_reserve(s, NULL, 1, &share) == STICTION_NULL && stiction_load_reserve(s, free_impulse, 1, NULL) == STICTION_NULL);
    CHECK(stiction_rest_reserve(s, NULL, 1, &share) == STICTION_NULL && stiction_rest_reserve(s, free_impulse, 1, NULL) == STICTION_NULL);
    CHECK(stiction_read(s, NULL) == STICTION_NULL && stiction_worst_violation(s, NULL) == STICTION_NULL);
    CHECK(stiction_last_culprit(s, NULL) == STICTION_NULL && stiction_describe(s, NULL, 9) == STICTION_NULL);
}

int main(void)
{
    nothing(s, STICTION_NOT_INITIALISED);
    CHECK(stiction_init_sized(s, sizeof(stiction) + 8, sizeof(stiction_solution)) == STICTION_WRONG_SIZES);
    CHECK(stiction_init_sized(s, sizeof(stiction), sizeof(stiction_solution) - 4) == STICTION_WRONG_SIZES);
    nothing(s, STICTION_NOT_INITIALISED);
    CHECK(stiction_init(s) == STICTION_OK && culprit().input == STICTION_INPUT_NONE && culprit().contact == -1);
    CHECK(!stiction_is_usable(s, 1) && stiction_read(s, &solution) == STICTION_OK);
    CHECK(solution.status == STICTION_UNSOLVED && solution.count == 0);
#if STICTION_C > 0
    answers();
    stop();
    endings();
    one_by_one();
    violations();
    relaxation();
    loads();
    flips();
    pieces();
    velocities();
    refusals();
#endif
    budgets();
    helpers();
    joint_rows();
    limits();
    refused_rows();
    nulls();
    CHECK(place.before == mark && place.after == mark);
    CHECK(strcmp(stiction_name(STICTION_SOLVED), "STICTION_SOLVED") == 0);
    CHECK(strcmp(stiction_name(stiction_init(s)), "STICTION_OK") == 0);
    CHECK(strcmp(stiction_name(STICTION_NO_SUCH_ROW), "STICTION_NO_SUCH_ROW") == 0 && strcmp(stiction_name(99), "?") == 0);
    CHECK(sizeof(enum stiction_status) == 4 && sizeof(enum stiction_mode) == 4 && sizeof(enum stiction_input) == 4);
    CHECK(sizeof(enum stiction_law) == 4 && sizeof(enum stiction_row_mode) == 4);
    printf("test.c: all as it should be\n");
    return 0;
}
