/* A control loop, to be changed into yours. A block of 2 kg lies on the floor and is pushed harder at each tick, until it
   slides; then a sensor breaks, the impulses of the last good tick stay, and when they are too old the machine stops. */
#include "stiction.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

_Static_assert(STICTION_N >= 3 && STICTION_D == 3, "the block has three velocities and a floor with two tangents");

enum { X, Y, Z, FLOOR = 7, AGE_LIMIT = 20 }; /* velocities; the key of the contact; ticks for which old impulses may stay */

static const char *const modes[] = {[STICTION_OPEN] = "open", [STICTION_STICK] = "sticks", [STICTION_SLIP] = "slips"};
static const stiction_real h = (stiction_real)1e-3; /* s, a tick */

static stiction solver;        /* all of stiction's memory: put it where you like */
static stiction_solution last; /* the last good one */
static int age;                /* how many ticks old it is */
static uint32_t budget;        /* work that a tick has time for */

/* The scene of a tick. In firmware: M and H of the robot's pose, contacts of its feet. */
static enum stiction_status fill(stiction_real height)
{
    static stiction_real mass[STICTION_N][STICTION_N]; /* kg */
    for (int i = 0; i < STICTION_N; i++) mass[i][i] = 2;
    enum stiction_status status = stiction_set_mass(&solver, STICTION_CONST(mass));
    if (status != STICTION_OK) return status;

    const stiction_real jacobian[STICTION_D][STICTION_N] = {[0][Z] = 1, [1][X] = 1, [2][Y] = 1}; /* normal first */
    const stiction_real offset[STICTION_D] = {height / h};                                      /* m/s */
    status = stiction_clear(&solver);
    if (status != STICTION_OK) return status;
    return stiction_add_contact(&solver, jacobian, offset, (stiction_real)0.5, FLOOR);
}

/* Solves a tick. Unless that goes well, the last good solution stays. */
static enum stiction_status tick(stiction_real push, stiction_real height)
{
    age++;
    enum stiction_status status = fill(height);
    if (status != STICTION_OK) return status;
    const stiction_real free_impulse[STICTION_N] = {[X] = push * h, [Z] = (stiction_real)(-2 * 9.81) * h}; /* N s */
    status = stiction_solve(&solver, free_impulse, (stiction_real)1e-4, budget);
    if (status < 0 || !stiction_is_usable(&solver, (stiction_real)1e-2)) return status;
    age = 0;
    stiction_read(&solver, &last);
    return status;
}

static void report(int push, enum stiction_status status)
{
    printf("%2d N: %s", push, stiction_name(status));
    for (uint32_t i = 0; i < last.count; i++) { /* by key: contacts come and go */
        const stiction_contact *contact = &last.contacts[i];
        printf(", contact %u %s, impulse %.5f %.5f %.5f N s", (unsigned)contact->key, modes[contact->mode],
               (double)contact->impulse[0], (double)contact->impulse[1], (double)contact->impulse[2]);
    }
    if (status < 0) {
        char text[100];
        stiction_describe(&solver, text, sizeof text);
        printf(" (as before, for: %s)", text);
    }
    printf("\n");
}

int main(void)
{
    /* A solve in 1 ms of an STM32H7, for the sizes of stiction_sizes.h. No bound is known for double: measure yours. */
    budget = sizeof(stiction_real) == sizeof(float) ? stiction_budget_within(1000, 480, 0) : 50;
    if (stiction_init(&solver) != STICTION_OK || budget == 0) return 1;
    for (int push = 0; age < AGE_LIMIT; push += 5) { /* N; friction holds 9.81 N */
        enum stiction_status status = tick((stiction_real)push, push < 20 ? 0 : (stiction_real)NAN);
        if (age <= 1) report(push, status); /* of those that are held the first */
    }
    printf("stopped: the impulses are %d ticks old\n", age); /* stop, as your robot does it safely */
    return 0;
}
