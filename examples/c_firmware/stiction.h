/* Coulomb friction with unilateral contact, for C and C++: which contacts stick, slip and let go within a time step.

       M v = M v_free + sum of H_i^T r_i,     u_i = H_i v + w_i,     Coulomb's law between u_i and r_i

   Matrices are row by row. Row 0 of a contact is its normal, out of the obstacle; the others are its tangents. Units: kg, m, s,
   rad, of rotations kg m^2 and N m s. lib.rs reads the numbers of this file as it is compiled: they cannot differ. */
#ifndef STICTION_H
#define STICTION_H

#include "stiction_sizes.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef STICTION_REAL stiction_real;

/* A scene, its factor and its solver: all memory there is, owned by the caller, in a `static` or wherever it likes. Two of
   them know nothing of each other. One is not to be used by two threads at a time, nor copied. */
typedef struct stiction {
    uint64_t memory[(STICTION_BYTES + 7) / 8];
} stiction;

/* How a call ended: 0 done or solved; > 0 how else a solve ended; < 0 what was wrong. A call with an error has changed nothing,
   and the last solution is still there. If stiction_add_contact fails, clear the contacts: half a scene can be solved, too. */
enum stiction_status {
    STICTION_OK = 0,     /* of a call that does not solve */
    STICTION_SOLVED = 0, /* the error is at most the tolerance */
    STICTION_OUT_OF_BUDGET = 1,   /* the budget is used up: the best solution so far; stiction_resume goes on */
    STICTION_PRECISION_LIMIT = 2, /* the error is above the tolerance, and the number type allows hardly less */
    STICTION_INFEASIBLE = 3,      /* no velocity satisfies all contacts: look at their offsets, and do not use this */
    STICTION_UNSOLVED = 4,        /* nothing was solved yet */

    STICTION_NULL = -1,                         /* a null pointer */
    STICTION_NOT_INITIALISED = -2,              /* stiction_init was not called on this memory */
    STICTION_NOT_FINITE = -3,                   /* an entry is NaN or infinite */
    STICTION_MASS_NOT_SYMMETRIC = -4,           /* M differs from its transpose by more than rounding */
    STICTION_MASS_NOT_POSITIVE_DEFINITE = -5,   /* said by a solve; also if no M was set */
    STICTION_INVALID_FRICTION = -6,             /* mu is negative, not finite, or its square overflows */
    STICTION_CONTACT_LIST_FULL = -7,            /* STICTION_C contacts are there already */
    STICTION_NO_SUCH_CONTACT = -8,              /* no contact has this index */
    STICTION_INVALID_TOLERANCE = -9,            /* the tolerance is negative or not finite */
    STICTION_DELASSUS_OVERFLOW = -10,           /* H M^-1 H^T of a contact overflows */
    STICTION_UNKNOWN = -11,                     /* an error that this header does not know: it is older than stiction */
    /* Errors of stiction that no call of this header can cause. */
    STICTION_INVALID_PENALTY = -12,
    STICTION_STALE_FACTOR = -13,
    STICTION_DELASSUS_NOT_GRAM = -14,
    STICTION_INVALID_BOUNDS = -15,
    STICTION_INVALID_COMPLIANCE = -16,
    STICTION_NO_SUCH_ROW = -17,
    STICTION_INVALID_PARAMETER = -18,

    STICTION_STATUS_WIDTH = 0x7fffffff /* keeps the enum at 32 bits where compilers make enums short, as for Arm */
};

/* What a contact does. */
enum stiction_mode {
    STICTION_OPEN = 0,  /* no impulse */
    STICTION_STICK = 1, /* an impulse inside the friction cone */
    STICTION_SLIP = 2,  /* an impulse on its boundary */
    STICTION_MODE_WIDTH = 0x7fffffff
};

/* Which input an error is about. */
enum stiction_input {
    STICTION_INPUT_NONE = 0,
    STICTION_INPUT_MASS = 1,
    STICTION_INPUT_FREE_IMPULSE = 2,
    STICTION_INPUT_JACOBIAN = 3,
    STICTION_INPUT_OFFSET = 4,
    STICTION_INPUT_FRICTION = 5,
    STICTION_INPUT_OTHER = 6,
    STICTION_INPUT_WIDTH = 0x7fffffff
};

/* Which entry of which contact; -1 where that has no meaning. */
typedef struct stiction_culprit {
    enum stiction_input input;
    int32_t contact, row, column;
} stiction_culprit;

/* One contact of a solution. */
typedef struct stiction_contact {
    uint32_t key; /* as it was given */
    enum stiction_mode mode;
    stiction_real impulse[STICTION_D];  /* r_i, N s */
    stiction_real velocity[STICTION_D]; /* u_i, m/s */
    stiction_real certificate; /* > 0 if the scene is infeasible and this contact has a part in it: see its offset */
} stiction_contact;

/* What a solve has found: plain numbers, to be copied and kept at will. */
typedef struct stiction_solution {
    enum stiction_status status;
    uint32_t work;  /* of all calls of the solve, in units of the budget */
    uint32_t count; /* contacts below, in the order they were added */
    stiction_real error; /* distance from Coulomb's law and the dynamics, relative to the impulses */
    stiction_real velocity[STICTION_N];
    stiction_contact contacts[STICTION_C];
} stiction_solution;

/* Before anything else. Any other call on memory that it has not seen returns STICTION_NOT_INITIALISED. */
enum stiction_status stiction_init(stiction *s);

/* Forgets the last solve: the next one starts cold. After a tick with wild numbers. M, contacts and the solution stay. */
enum stiction_status stiction_reset(stiction *s);

/* Mass matrix M. */
enum stiction_status stiction_set_mass(stiction *s, const stiction_real mass[STICTION_N][STICTION_N]);

/* Contacts, anew at each tick if they come and go: Jacobian H_i, offset w_i (m/s: moving surface, gap over time step,
   restitution), friction coefficient, and a number of your own that says which contact it is: a warm start follows it. */
enum stiction_status stiction_clear_contacts(stiction *s);
enum stiction_status stiction_add_contact(stiction *s, const stiction_real jacobian[STICTION_D][STICTION_N],
                                          const stiction_real offset[STICTION_D], stiction_real mu, uint32_t key);

/* The same contacts with other numbers, in the order they were added, from 0. Offset and friction cost nothing; after M or a
   Jacobian has changed the next solve factorises first. */
enum stiction_status stiction_set_jacobian(stiction *s, uint32_t contact, const stiction_real jacobian[STICTION_D][STICTION_N]);
enum stiction_status stiction_set_offset(stiction *s, uint32_t contact, const stiction_real offset[STICTION_D]);
enum stiction_status stiction_set_friction(stiction *s, uint32_t contact, stiction_real mu);

/* Solves for a free impulse M v_free (N s) to an error of `tolerance`; 1e-4 suits float. A call does at most `budget` work
   and 27 more: a Newton step counts 10, a sweep 2. If the budget has ended, resume goes on, with the same free impulse and
   tolerance, and in how many calls makes no difference, except that STICTION_INFEASIBLE may come sooner. Otherwise resume
   solves. */
enum stiction_status stiction_solve(stiction *s, const stiction_real free_impulse[STICTION_N], stiction_real tolerance,
                                    uint32_t budget);
enum stiction_status stiction_resume(stiction *s, const stiction_real free_impulse[STICTION_N], stiction_real tolerance,
                                     uint32_t budget);

/* May the last solution be used? It is solved, or the budget or the number type ended it at an error of at most `error`. If
   not, use the impulses of an earlier tick. After a solve with an error the last solution is that of an earlier tick. */
bool stiction_is_usable(const stiction *s, stiction_real error);

/* Copies the last solution. Contacts from `count` on are zero. */
enum stiction_status stiction_read(const stiction *s, stiction_solution *solution);

/* What the last error was about. */
enum stiction_status stiction_last_culprit(const stiction *s, stiction_culprit *culprit);

/* The last error in words, at most `bytes` with the zero at the end; some KB of flash if it is called. */
enum stiction_status stiction_describe(const stiction *s, char *text, size_t bytes);

/* The name of a status, "STICTION_SOLVED"; "?" of any other number. */
const char *stiction_name(int32_t status);

#ifdef __cplusplus
}
#endif

#endif
