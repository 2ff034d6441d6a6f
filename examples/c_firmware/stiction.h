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
    STICTION_MAX_ITERATIONS = 1,  /* the budget has ended: the best that was found so far */
    STICTION_PRECISION_LIMIT = 2, /* it is not, and float does not allow much better */
    STICTION_INFEASIBLE = 3,      /* no velocity satisfies all contacts */
    STICTION_UNKNOWN = 4,         /* a status this header does not know */
    /* What was wrong with a call, which then has changed nothing. */
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

/* Solves for a free impulse M v_free (N s) to an error of `tolerance`, with at most `budget` iterations,
   of which a Newton step counts as ten. Factorises first where the mass matrix or a Jacobian has
   changed. Where the budget ends, resume goes on with the same free impulse: in how
   many calls a solve is done makes no difference to its result, but that STICTION_INFEASIBLE may come
   sooner. */
int32_t stiction_solve(stiction *s, const float free_impulse[STICTION_N], float tolerance,
                       uint32_t budget);
int32_t stiction_resume(stiction *s, const float free_impulse[STICTION_N], float tolerance,
                        uint32_t budget);

/* The last solution: velocities, impulses (normal first), and how exact it is. Null: not wanted. */
int32_t stiction_read(const stiction *s, float velocity[STICTION_N],
                      float impulses[STICTION_C][STICTION_D], float *error);

#endif
