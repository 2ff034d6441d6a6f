/* A control loop, to be changed into yours. A block of 2 kg lies on the floor and is pushed harder at each tick, until it
   slides; then a sensor fails, and the impulses of the last good tick stay. */
#include "stiction.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

_Static_assert(STICTION_N >= 3 && STICTION_D == 3, "the block has three velocities and a floor with two tangents");

enum { X, Y, Z, FLOOR = 7, BUDGET = 100 }; /* velocities; the key of the contact; work that a tick has time for */

static const char *const modes[] = {[STICTION_OPEN] = "open", [STICTION_STICK] = "sticks", [STICTION_SLIP] = "slips"};
static const stiction_real h = (stiction_real)1e-3; /* s, a tick */

static stiction solver;        /* all of stiction's memory: put it where you like */
static stiction_solution last; /* the last good one */

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
    status = stiction_add_contact(&solver, jacobian, offset, (stiction_real)0.5, FLOOR);
    if (status != STICTION_OK) stiction_clear(&solver); /* not half a scene */
    return status;
}

/* Solves a tick. Unless that goes well, the last good solution stays. */
static enum stiction_status tick(stiction_real push, stiction_real height)
{
    enum stiction_status status = fill(height);
    if (status != STICTION_OK) return status;
    const stiction_real free_impulse[STICTION_N] = {[X] = push * h, [Z] = (stiction_real)(-2 * 9.81) * h}; /* N s */
    status = stiction_solve(&solver, free_impulse, (stiction_real)1e-4, BUDGET);
    if (stiction_is_usable(&solver, (stiction_real)1e-2) && status >= 0) stiction_read(&solver, &last);
    return status;
}

int main(void)
{
    if (stiction_init(&solver) != STICTION_OK) return 1;
    for (int push = 0; push <= 20; push += 5) { /* N; friction holds 9.81 N */
        enum stiction_status status = tick((stiction_real)push, push == 20 ? (stiction_real)NAN : 0);
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
    return 0;
}
