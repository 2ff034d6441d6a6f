/* Coulomb friction with unilateral contact, for C. Sizes are fixed here and in lib.rs beside. */
#ifndef STICTION_H
#define STICTION_H

#include <stdint.h>

enum {
    STICTION_N = 18, /* generalised velocities */
    STICTION_D = 3,  /* rows of a contact: normal, tangent, tangent */
    STICTION_C = 5   /* most contacts */
};

/* All a solver needs, about 10 KiB: the caller owns it, and sees nothing of what is in it. Not to be
   used by two threads at a time, nor copied while it is in use. */
typedef struct {
    _Alignas(8) unsigned char bytes[10240];
} stiction;

enum {
    /* How a solve ended. */
    STICTION_SOLVED = 0,          /* the error is at most the tolerance */
    STICTION_OUT_OF_BUDGET = 1,   /* the budget was used up: the best solution so far, resume goes on */
    STICTION_PRECISION_LIMIT = 2, /* the error is above the tolerance, and float allows hardly less */
    STICTION_INFEASIBLE = 3,      /* no velocity satisfies all contacts */
    STICTION_UNKNOWN = 4,         /* a status this header does not know */
    /* What was wrong with a call. It has changed nothing, and the last solution is still that of the last solve.
       If stiction_add_contact fails, clear the contacts: half a scene can be solved, too. */
    STICTION_NULL = -1,           /* a null pointer */
    STICTION_MEMORY = -2,         /* `stiction` is too small: sizes here and in lib.rs differ */
    STICTION_NOT_FINITE = -3,     /* an entry is NaN or infinite */
    STICTION_MASS = -4,           /* M is not symmetric and positive definite */
    STICTION_FRICTION = -5,       /* mu is negative, not finite or too large */
    STICTION_FULL = -6,           /* STICTION_C contacts are there already */
    STICTION_TOLERANCE = -7,      /* the tolerance is negative or not finite */
    STICTION_OTHER = -8
};

/* Before anything else. */
int32_t stiction_init(stiction *s);

/* Mass matrix M (kg), row by row. */
int32_t stiction_set_mass(stiction *s, const float mass[STICTION_N][STICTION_N]);

/* Contacts, anew at each step: Jacobian H_i, offset w_i (m/s), friction coefficient, and a number
   of your own that says which contact it is: a warm start follows it from solve to solve. */
int32_t stiction_clear_contacts(stiction *s);
int32_t stiction_add_contact(stiction *s, const float jacobian[STICTION_D][STICTION_N],
                             const float offset[STICTION_D], float mu, uint32_t key);

/* Solves for a free impulse M v_free (N s) to an error of `tolerance`. A call may do `budget` work, and 27 more: a Newton
   step counts 10, a sweep 2. Factorises first if the mass matrix or a Jacobian has changed. If the budget ended,
   resume goes on with the same free impulse. The number of calls makes no difference to the result, except that
   STICTION_INFEASIBLE may come sooner. */
int32_t stiction_solve(stiction *s, const float free_impulse[STICTION_N], float tolerance,
                       uint32_t budget);
int32_t stiction_resume(stiction *s, const float free_impulse[STICTION_N], float tolerance,
                        uint32_t budget);

/* 1 if the last solution may be used: it is solved, or the budget or float ended it at an error of at most `error`.
   0 if not: use the impulses of an earlier tick. */
int32_t stiction_is_usable(const stiction *s, float error);

/* Reads the last solution: velocities, keys and impulses (N s, normal first) of its contacts, and its error. Returns the
   number of contacts. Null: not wanted. */
int32_t stiction_read(const stiction *s, float velocity[STICTION_N], uint32_t keys[STICTION_C],
                      float impulses[STICTION_C][STICTION_D], float *error);

#endif
