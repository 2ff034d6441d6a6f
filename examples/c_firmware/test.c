/* The C interface on this machine, `make test`: answers known on paper, every kind of refusal, nothing written beyond its
   place. Holds for any sizes with at least three velocities. */
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

static const uint64_t mark = 0xA5A5A5A5A5A5A5A5u;
static struct { uint64_t before; stiction solver; uint64_t after; } place = {mark, {{0}}, mark};
static stiction *const s = &place.solver;
static stiction_real mass[STICTION_N][STICTION_N], jacobian[STICTION_D][STICTION_N], offset[STICTION_D];
static stiction_real free_impulse[STICTION_N];
static stiction_solution solution;

static bool near(stiction_real x, double expected) { return fabs((double)x - expected) < 1e-5; }

static stiction_culprit culprit(void)
{
    stiction_culprit culprit;
    CHECK(stiction_last_culprit(s, &culprit) == STICTION_OK);
    return culprit;
}

/* A point of 2 kg over a floor: velocity 0 is up, the next ones lie along the floor. */
static void point(double mu)
{
    memset(mass, 0, sizeof mass);
    for (int i = 0; i < STICTION_N; i++) mass[i][i] = 2;
    for (int i = 0; i < STICTION_D && i < STICTION_N; i++) jacobian[i][i] = 1;
    CHECK(stiction_set_mass(s, mass) == STICTION_OK);
    CHECK(stiction_clear_contacts(s) == STICTION_OK);
    CHECK(stiction_add_contact(s, jacobian, offset, (stiction_real)mu, 42) == STICTION_OK);
}

static enum stiction_status solve(double up, double along, uint32_t budget)
{
    free_impulse[0] = (stiction_real)up;
    free_impulse[1] = (stiction_real)along;
    return stiction_solve(s, free_impulse, (stiction_real)1e-5, budget);
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
        CHECK(stiction_set_friction(s, 0, 0) == STICTION_OK); /* nothing is factorised for it */
        CHECK(solve(-2, 3, 1000) == STICTION_SOLVED && stiction_read(s, &solution) == STICTION_OK);
        CHECK(near(contact->impulse[1], 0) && near(solution.velocity[1], 1.5));
        CHECK(stiction_set_friction(s, 0, (stiction_real)0.5) == STICTION_OK);
    }
    CHECK(solve(2, 0, 1000) == STICTION_SOLVED && stiction_read(s, &solution) == STICTION_OK);
    CHECK(contact->mode == STICTION_OPEN && contact->impulse[0] == 0 && near(solution.velocity[0], 1));
    CHECK(solution.contacts[STICTION_C - 1].key == (STICTION_C > 1 ? 0 : 42));

    offset[0] = -3; /* a floor that rises with 3 m/s */
    CHECK(stiction_set_offset(s, 0, offset) == STICTION_OK && solve(0, 0, 1000) == STICTION_SOLVED);
    CHECK(stiction_read(s, &solution) == STICTION_OK && near(solution.velocity[0], 3) && near(contact->impulse[0], 6));
    offset[0] = 0;
    jacobian[0][0] = -1; /* it is the ceiling now */
    CHECK(stiction_set_jacobian(s, 0, jacobian) == STICTION_OK && solve(2, 0, 1000) == STICTION_SOLVED);
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
    if (STICTION_C > 1) CHECK(stiction_add_contact(s, row, offset, 0, 7) == STICTION_OK);
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
        CHECK(stiction_add_contact(s, jacobian, offset, 0, 43) == STICTION_OK);
        CHECK(solve(0, 0, 1000) == STICTION_INFEASIBLE && !stiction_is_usable(s, 1));
        CHECK(stiction_read(s, &solution) == STICTION_OK && solution.status == STICTION_INFEASIBLE);
        CHECK(solution.contacts[0].certificate > 0 && solution.contacts[1].certificate > 0);
    }
    offset[0] = 0;
    jacobian[0][0] = 1;
    /* Contacts that push a point obliquely take more than no work. */
    point(0.5);
    for (int i = 1; i < STICTION_C; i++) {
        jacobian[0][1] = (stiction_real)(0.1 * i);
        CHECK(stiction_add_contact(s, jacobian, offset, (stiction_real)0.3, (uint32_t)i) == STICTION_OK);
    }
    jacobian[0][1] = 0;
    CHECK(stiction_reset(s) == STICTION_OK);
    enum stiction_status status = solve(-2, -3, 0);
    CHECK(status == STICTION_OUT_OF_BUDGET);
    CHECK(stiction_read(s, &solution) == STICTION_OK && solution.status == status);
    CHECK(stiction_is_usable(s, solution.error) && !stiction_is_usable(s, solution.error / 2));
    for (int i = 0; i < 1000 && status == STICTION_OUT_OF_BUDGET; i++)
        status = stiction_resume(s, free_impulse, (stiction_real)1e-5, 1);
    CHECK(status == STICTION_SOLVED || status == STICTION_PRECISION_LIMIT);
}

/* What is refused, and what it is about. A refused call changes nothing. */
static void refusals(void)
{
    point(0.5);
    CHECK(solve(-2, 0.75, 1000) == STICTION_SOLVED);
    mass[2][1] = NAN;
    CHECK(stiction_set_mass(s, mass) == STICTION_NOT_FINITE);
    CHECK(culprit().input == STICTION_INPUT_MASS && culprit().row == 2 && culprit().column == 1 && culprit().contact == -1);
    mass[2][1] = 1;
    CHECK(stiction_set_mass(s, mass) == STICTION_MASS_NOT_SYMMETRIC && culprit().row == 2 && culprit().column == 1);
    jacobian[0][2] = INFINITY;
    CHECK(stiction_set_jacobian(s, 0, jacobian) == STICTION_NOT_FINITE && culprit().input == STICTION_INPUT_JACOBIAN);
    CHECK(culprit().contact == 0 && culprit().row == 0 && culprit().column == 2);
    jacobian[0][2] = 0;
    CHECK(stiction_set_jacobian(s, 9, jacobian) == STICTION_NO_SUCH_CONTACT && culprit().contact == 9);
    offset[STICTION_D - 1] = NAN;
    CHECK(stiction_set_offset(s, 0, offset) == STICTION_NOT_FINITE && culprit().input == STICTION_INPUT_OFFSET);
    CHECK(culprit().contact == 0 && culprit().row == STICTION_D - 1);
    offset[STICTION_D - 1] = 0;
    CHECK(stiction_set_friction(s, 0, -1) == STICTION_INVALID_FRICTION && culprit().input == STICTION_INPUT_FRICTION);
    for (int i = 1; i < STICTION_C; i++) CHECK(stiction_add_contact(s, jacobian, offset, 1, 1) == STICTION_OK);
    CHECK(stiction_add_contact(s, jacobian, offset, 1, 1) == STICTION_CONTACT_LIST_FULL && culprit().contact == STICTION_C);
    CHECK(stiction_solve(s, free_impulse, -1, 10) == STICTION_INVALID_TOLERANCE);
    free_impulse[2] = NAN;
    CHECK(stiction_solve(s, free_impulse, 1, 10) == STICTION_NOT_FINITE && culprit().input == STICTION_INPUT_FREE_IMPULSE);
    CHECK(culprit().row == 2);
    char text[80] = "", cut[10];
    CHECK(stiction_describe(s, text, sizeof text) == STICTION_OK);
    CHECK(strcmp(text, "free impulse: entry (2, 0) is not finite") == 0);
    CHECK(stiction_describe(s, cut, sizeof cut) == STICTION_OK && strcmp(cut, "free impu") == 0);
    CHECK(stiction_describe(s, cut, 0) == STICTION_OK && cut[0] == 'f');
    free_impulse[2] = 0;
    mass[0][0] = -2;
    mass[2][1] = 0;
    CHECK(stiction_set_mass(s, mass) == STICTION_OK && solve(-2, 0, 10) == STICTION_MASS_NOT_POSITIVE_DEFINITE);
    CHECK(culprit().input == STICTION_INPUT_MASS && culprit().row == 0);
    /* The last solution is still there. */
    CHECK(stiction_is_usable(s, 0) && stiction_read(s, &solution) == STICTION_OK && solution.count == 1);
}

static void nothing(stiction *none, enum stiction_status status)
{
    char text[8];
    stiction_culprit culprit;
    CHECK(stiction_reset(none) == status && stiction_set_mass(none, mass) == status);
    CHECK(stiction_clear_contacts(none) == status && stiction_add_contact(none, jacobian, offset, 1, 0) == status);
    CHECK(stiction_set_jacobian(none, 0, jacobian) == status && stiction_set_offset(none, 0, offset) == status);
    CHECK(stiction_set_friction(none, 0, 1) == status && stiction_solve(none, free_impulse, 1, 9) == status);
    CHECK(stiction_resume(none, free_impulse, 1, 9) == status && !stiction_is_usable(none, 1));
    CHECK(stiction_read(none, &solution) == status && stiction_last_culprit(none, &culprit) == status);
    CHECK(stiction_describe(none, text, sizeof text) == status);
}

static void nulls(void)
{
    nothing(NULL, STICTION_NULL);
    CHECK(stiction_init(NULL) == STICTION_NULL && stiction_set_mass(s, NULL) == STICTION_NULL);
    CHECK(stiction_add_contact(s, NULL, offset, 1, 0) == STICTION_NULL);
    CHECK(stiction_add_contact(s, jacobian, NULL, 1, 0) == STICTION_NULL);
    CHECK(stiction_set_jacobian(s, 0, NULL) == STICTION_NULL && stiction_set_offset(s, 0, NULL) == STICTION_NULL);
    CHECK(stiction_solve(s, NULL, 1, 9) == STICTION_NULL && stiction_resume(s, NULL, 1, 9) == STICTION_NULL);
    CHECK(stiction_read(s, NULL) == STICTION_NULL && stiction_last_culprit(s, NULL) == STICTION_NULL);
    CHECK(stiction_describe(s, NULL, 9) == STICTION_NULL);
}

int main(void)
{
    nothing(s, STICTION_NOT_INITIALISED);
    CHECK(stiction_init(s) == STICTION_OK && culprit().input == STICTION_INPUT_NONE && culprit().contact == -1);
    answers();
    stop();
    endings();
    refusals();
    nulls();
    CHECK(place.before == mark && place.after == mark);
    CHECK(strcmp(stiction_name(STICTION_SOLVED), "STICTION_SOLVED") == 0);
    CHECK(strcmp(stiction_name(STICTION_NO_SUCH_ROW), "STICTION_NO_SUCH_ROW") == 0 && strcmp(stiction_name(99), "?") == 0);
    CHECK(sizeof(enum stiction_status) == 4 && sizeof(enum stiction_mode) == 4 && sizeof(enum stiction_input) == 4);
    printf("test.c: all as it should be\n");
    return 0;
}
