/* Coulomb friction with unilateral contact, for C and C++: which contacts stick, slip and let go within a time step; and
   joint rows beside them, for stops, motors, dry friction and loops.

       M v = M v_free + sum of H_i^T r_i + sum of J_j^T l_j

       u_i = H_i v + w_i                Coulomb's law between u_i and the impulse r_i of contact i
       s_j = J_j v + w_j + R_j l_j      a law of its own between s_j and the impulse l_j of joint row j

   Matrices are row by row. Row 0 of a contact is its normal, out of the obstacle; the others are its tangents, then spin, then
   two rolls. Units: kg, m, s, rad, of rotations kg m^2 and N m s. status.rs reads the numbers of this file as it is compiled: they
   cannot differ. */
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

/* A matrix of its own where one that is only read is asked for: ISO C before C23 takes them for different types, and compilers
   warn, some with -Wpedantic alone. stiction_set_mass(&s, STICTION_CONST(mass)), where `mass` is not const. */
#if defined __cplusplus || defined __STDC_VERSION__ && __STDC_VERSION__ > 201710L
#define STICTION_CONST(matrix) (matrix)
#elif defined __STDC_VERSION__ && __STDC_VERSION__ >= 201112L
#define STICTION_CONST(matrix) \
    _Generic((matrix), stiction_real(*)[STICTION_N]: (const stiction_real(*)[STICTION_N])(matrix), default: (matrix))
#else
#define STICTION_CONST(matrix) ((const stiction_real(*)[STICTION_N])(matrix))
#endif

/* How a call ended: 0 done; > 0 how a solve ended; < 0 what was wrong. A call with an error has changed nothing,
   and the last solution is still there. After a contact or joint row that was refused no solve takes the scene until stiction_clear, after a
   mass matrix until another one is set: STICTION_SCENE_INCOMPLETE. */
enum stiction_status {
    STICTION_OK = 0,              /* of a call that does not solve */
    STICTION_SOLVED = 6,          /* the error is at most the tolerance */
    STICTION_OUT_OF_BUDGET = 1,   /* the budget is used up: the best solution so far; stiction_resume goes on */
    STICTION_PRECISION_LIMIT = 2, /* the error is above the tolerance, and the number type allows hardly less */
    STICTION_INFEASIBLE = 3,      /* no velocity satisfies all contacts and joint rows: see their offsets, and do not use this */
    STICTION_UNSOLVED = 4,        /* nothing was solved yet, or stiction_advance has not come to an end */
    STICTION_OUT_OF_ROWS = 7,     /* more limits are reached than there is room for: the error counts those that are left out */
    STICTION_JAMMED = 5,          /* none was found, and friction locks what is to be pushed apart: see the offsets, and do not use this */

    STICTION_NULL = -1,                       /* a null pointer */
    STICTION_NOT_INITIALISED = -2,            /* stiction_init was not called on this memory */
    STICTION_NOT_FINITE = -3,                 /* an entry is NaN or infinite */
    STICTION_MASS_NOT_SYMMETRIC = -4,         /* M differs from its transpose by more than rounding */
    STICTION_MASS_NOT_POSITIVE_DEFINITE = -5, /* said by a solve; also if no M was set */
    STICTION_INVALID_FRICTION = -6,           /* mu is negative, not finite, or its square overflows; a surface cannot take it */
    STICTION_CONTACT_LIST_FULL = -7,          /* STICTION_C contacts are there already */
    STICTION_NO_SUCH_CONTACT = -8,            /* no contact has this index */
    STICTION_INVALID_TOLERANCE = -9,          /* the tolerance is negative or not finite */
    STICTION_DELASSUS_OVERFLOW = -10,         /* said by a solve: H M^-1 H^T of a contact overflows or vanishes */
    STICTION_UNKNOWN = -11,                   /* an error that this header does not know: it is older than stiction */
    STICTION_INVALID_BOUNDS = -15,            /* bounds of a joint row are not finite, or lower > upper */
    STICTION_INVALID_COMPLIANCE = -16,        /* a compliance of a contact is negative or not finite */
    STICTION_NO_SUCH_ROW = -17,               /* no joint row has this index */
    STICTION_ROW_LIST_FULL = -19,             /* STICTION_R joint rows are there already */
    STICTION_IMPULSE_LIST_FULL = -20,         /* more initial impulses than STICTION_C or STICTION_R */
    STICTION_NO_SUCH_KEY = -21,               /* nothing has this key */
    STICTION_ROW_OUT_OF_RANGE = -22,          /* said by a solve: J M^-1 J^T + R of a joint row overflows or vanishes */
    STICTION_INVALID_ROW_COMPLIANCE = -23,    /* the compliance of a joint row is negative or not finite */
    STICTION_INVALID_LAW = -24,               /* a number that is none of enum stiction_law */
    STICTION_WRONG_SIZES = -25,               /* the library was built with another stiction_sizes.h: build all anew */
    STICTION_SURFACE_LIST_FULL = -27,         /* STICTION_S contacts have a surface already */
    STICTION_INVALID_LIMIT = -28,             /* bounds or compliance of a limit are refused as those of a joint row would be */
    STICTION_LIMITS_LEFT_OUT = -29,           /* the solve that was paused has limits: stiction_resume_with_limits goes on */
    STICTION_LIMIT_LIST_FULL = -30,           /* more than STICTION_L limits */
    STICTION_SCENE_INCOMPLETE = -31,          /* said by a solve: a part of the scene was refused, and is missing */
    STICTION_INVALID_VELOCITY_COUNT = -32,    /* a scene has 1 to STICTION_N velocities */
    STICTION_INVALID_PARAMETER = -18,         /* of stiction_gap_offset, _contact_frame and _contact_rows: an argument has no meaning */
    STICTION_INVALID_MODEL = -33,             /* a number that is none of enum stiction_model */
    STICTION_NO_SOLUTION = -34,               /* the last solution is not as exact as asked, or not one of the scene as it is now */
    STICTION_LIMIT_KEY_TAKEN = -35,           /* a limit has the key of an earlier limit or of a joint row of the scene */
    STICTION_STALE_FACTOR = -13,              /* M, a Jacobian or the contacts have changed since the last solve */
    /* An error of stiction that no call of this header can cause. */
    STICTION_INVALID_PENALTY = -12,

    STICTION_STATUS_WIDTH = 0x7fffffff /* keeps the enum at 32 bits where compilers make enums short, as for Arm */
};

/* The law of contacts that a solve obeys. */
enum stiction_model {
    STICTION_COULOMB = 0,           /* Coulomb's law */
    STICTION_CONVEX_RELAXATION = 1, /* a contact that slides opens with mu times its speed: to share out forces, where nothing slides */
    STICTION_MODEL_WIDTH = 0x7fffffff
};

/* What a contact does. */
enum stiction_mode {
    STICTION_OPEN = 0,  /* no impulse */
    STICTION_STICK = 1, /* an impulse inside the friction cone */
    STICTION_SLIP = 2,  /* an impulse on its boundary */
    STICTION_MODE_WIDTH = 0x7fffffff
};

/* What binds the impulse of a joint row to its velocity s. */
enum stiction_law {
    STICTION_LIMIT = 0,    /* impulse >= 0, s >= 0, and one of them is 0: a joint's stop */
    STICTION_EQUALITY = 1, /* s = 0, whatever impulse that takes: a loop that is closed, a gear */
    STICTION_BOX = 2,      /* lower <= impulse <= upper, at lower while s > 0, at upper while s < 0: dry friction, a motor */
    STICTION_LAW_WIDTH = 0x7fffffff
};

/* What a joint row does. */
enum stiction_row_mode {
    STICTION_ROW_OPEN = 0,     /* a limit that is not reached; no impulse */
    STICTION_ROW_AT_LIMIT = 1, /* a limit that is reached, and pushes */
    STICTION_ROW_AT_LOWER = 2, /* a box at its lower bound: a motor that can do no more, friction that slips */
    STICTION_ROW_AT_UPPER = 3, /* a box at its upper bound */
    STICTION_ROW_HOLDING = 4,  /* an equality, or a box within its bounds */
    STICTION_ROW_MODE_WIDTH = 0x7fffffff
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
    STICTION_INPUT_JOINT_ROW = 7, /* its row; with `row` = STICTION_N its offset */
    STICTION_INPUT_BOUNDS = 8,
    STICTION_INPUT_COMPLIANCE = 9, /* of a contact or of a joint row */
    STICTION_INPUT_INITIAL_IMPULSE = 10,     /* `contact` is its place in the list */
    STICTION_INPUT_INITIAL_ROW_IMPULSE = 11, /* `joint_row` is its place in the list */
    STICTION_INPUT_LIMIT = 12,               /* `joint_row` is its place in the list; its offset is `row` STICTION_N */
    STICTION_INPUT_CONTACT = 13,             /* one that is missing */
    STICTION_INPUT_VELOCITIES = 14,          /* their number; `row` is the largest one */
    STICTION_INPUT_WIDTH = 0x7fffffff
};

/* Which entry of which contact or joint row; -1 where that has no meaning. */
typedef struct stiction_culprit {
    enum stiction_input input;
    int32_t contact, joint_row; /* indices; how many there is room for if a list is full */
    int32_t row, column;        /* of the entry */
    int64_t key;                /* of what is told by its key */
} stiction_culprit;

/* How a contact rubs and gives way, where that is not one coefficient. The cone is elliptic, the sum of (r_k / mu_k)^2 over the
   rows behind the normal at most r_N^2. What a contact has no row for does not count; a coefficient of 0 lets its row go free. */
typedef struct stiction_surface {
    stiction_real friction[2];   /* along the two tangents */
    stiction_real spin;          /* about the normal, m; STICTION_D = 4 and 6 */
    stiction_real roll[2];       /* about the two tangents, m; STICTION_D = 6 */
    stiction_real compliance[2]; /* along the normal and along the tangents, 1/kg: velocity that an impulse adds; 0 is rigid */
} stiction_surface;

/* A joint row, to be added. What is not written in {.row = {[KNEE] = 1}} is 0: a rigid limit at its stop. */
typedef struct stiction_joint_row {
    stiction_real row[STICTION_N]; /* J_j: velocity of the row from those of the robot; a unit row at a joint */
    stiction_real offset;          /* w_j, m/s or rad/s: way to the stop or drift of the loop over the time step */
    enum stiction_law law;
    stiction_real lower, upper; /* of STICTION_BOX, N s or N m s: of dry friction -/+ its torque times the time step */
    stiction_real compliance;   /* R_j, unit of s over that of the impulse; 0 is rigid */
    uint32_t key;               /* a number of your own, as of a contact; rows and contacts apart */
} stiction_joint_row;

/* Impulses to start at, with the keys of their contacts and joint rows. */
typedef struct stiction_contact_impulse {
    uint32_t key;
    stiction_real impulse[STICTION_D]; /* N s, with spin and roll N m s */
} stiction_contact_impulse;
typedef struct stiction_row_impulse {
    uint32_t key;
    stiction_real impulse; /* N s or N m s */
} stiction_row_impulse;

/* One contact of a solution. */
typedef struct stiction_contact {
    uint32_t key; /* as it was given */
    enum stiction_mode mode;
    stiction_real impulse[STICTION_D];  /* r_i, N s */
    stiction_real velocity[STICTION_D]; /* u_i, m/s */
    stiction_real certificate[STICTION_D]; /* not 0 if the scene is infeasible or jammed and this contact has a part in it: see
                                              its offset; normal first, and along normals alone if infeasible */
} stiction_contact;

/* One joint row of a solution. */
typedef struct stiction_row {
    uint32_t key; /* as it was given */
    enum stiction_row_mode mode;
    stiction_real impulse;     /* l_j, N s along a length, N m s about an axis */
    stiction_real velocity;    /* s_j, m/s or rad/s */
    stiction_real certificate; /* not 0 if the scene is infeasible or jammed and this row has a part in it */
} stiction_row;

/* The worst violations of Coulomb's law and of the laws of joint rows, each the largest of all contacts or rows. */
typedef struct stiction_violation {
    stiction_real closing_speed;    /* the fastest at which a contact closes that has no gap left, m/s */
    stiction_real opening_impulse;  /* normal impulse of a contact that opens, N s: at most what would stop the opening */
    stiction_real outside_cone;     /* how far an impulse lies outside of its friction cone, N s */
    stiction_real creep;            /* how fast a contact moves along its tangents that friction could stop, m/s */
    stiction_real missing_friction; /* how far friction is from mu r_N against the motion of a contact that slides, N s */
    stiction_real row_speed;        /* the fastest at which a joint row goes where it must not, m/s or rad/s: a stop gives way */
    stiction_real row_impulse;      /* how far a row's impulse is from where its speed puts it, N s or N m s: dry friction that does not act */
} stiction_violation;

/* What a solve has found: plain numbers, to be copied and kept at will. Without room for contacts or for joint rows the list is
   not there, as C knows no empty ones. */
typedef struct stiction_solution {
    enum stiction_status status;
    uint32_t work;  /* of all calls of the solve, in units of the budget */
    uint32_t count; /* contacts below, in the order of the scene */
    stiction_real error; /* distance from the laws and the dynamics, relative to the impulses */
    stiction_real velocity[STICTION_N];
#if STICTION_C > 0
    stiction_contact contacts[STICTION_C];
#endif
#if STICTION_R > 0
    uint32_t row_count; /* joint rows below, in the order of the scene */
    stiction_row rows[STICTION_R];
#endif
} stiction_solution;

/* Before anything else. Any other call on memory that it has not seen returns STICTION_NOT_INITIALISED. (The library is told the
   sizes of this header, in bytes.) */
enum stiction_status stiction_init_sized(stiction *s, size_t bytes, size_t solution_bytes);
static inline enum stiction_status stiction_init(stiction *s)
{
    return stiction_init_sized(s, sizeof(stiction), sizeof(stiction_solution));
}

/* Forgets the last solve: the next one starts cold. After a tick with wild numbers. The scene and the solution stay. */
enum stiction_status stiction_reset(stiction *s);

/* The law of contacts from the next solve on; after stiction_init it is Coulomb's. A solve that was paused begins anew under another law. */
enum stiction_status stiction_set_model(stiction *s, enum stiction_model model);

/* Speed along its tangents, m/s, up to which a contact counts as one that sticks, from the next call on; 0 after stiction_init. It changes
   the mode of contacts and no motion. */
enum stiction_status stiction_set_still(stiction *s, stiction_real speed);

/* How many of STICTION_N velocities there are, from 1 on; after stiction_init all of them. One solver for several robots, or for one that
   picks something up. Of all matrices, rows and vectors over the velocities the first rows, columns and entries count; what stands behind
   them is not read, and 0 in a solution. A number that is not the last one removes M, contacts and joint rows. */
enum stiction_status stiction_set_velocities(stiction *s, uint32_t velocities);

/* Mass matrix M. */
enum stiction_status stiction_set_mass(stiction *s, const stiction_real mass[STICTION_N][STICTION_N]);

/* Removes all contacts and joint rows, or either of them. */
enum stiction_status stiction_clear(stiction *s);
enum stiction_status stiction_clear_contacts(stiction *s);
enum stiction_status stiction_clear_rows(stiction *s);

/* Dimensions of the space that contacts stand in. */
#define STICTION_K (STICTION_D == 2 ? 2 : 3)

/* Helpers that need no stiction, with the bits of those in Rust. What they refuse is STICTION_INVALID_PARAMETER, and nothing is written.

   The offset of a contact's normal, or of a stop, from the `distance` to it: distance / step, m/s or rad/s. `recovery` is the largest speed
   at which a penetration is pushed out (0 leaves it, INFINITY throws it out within the step), `reach` the largest offset, about the largest
   speed that is expected, or INFINITY. */
enum stiction_status stiction_gap_offset(stiction_real distance, stiction_real recovery, stiction_real reach, stiction_real step,
                                         stiction_real *offset);

/* Axes of a contact with this unit normal, out of the obstacle: row 0 is the normal, the others are the tangents. Of a surface that moves
   with velocity c the offset of row k is minus c along axis k. */
enum stiction_status stiction_contact_frame(const stiction_real normal[STICTION_K], stiction_real frame[STICTION_K][STICTION_K]);

/* The Jacobian of a contact at a point: `velocity` is the Jacobian of the point's velocity in the coordinates of the normal. With rows for
   spin or roll (STICTION_D = 4 and 6) `turning` is that of the angular velocity, otherwise it is not read, and may be null. */
enum stiction_status stiction_contact_rows(const stiction_real normal[STICTION_K], const stiction_real velocity[STICTION_K][STICTION_N],
                                           const stiction_real turning[STICTION_K][STICTION_N],
                                           stiction_real jacobian[STICTION_D][STICTION_N]);

/* Contacts, anew at each tick if they come and go: Jacobian H_i, offset w_i (m/s: moving surface, gap over time step,
   restitution), friction coefficient or surface, and a number of your own that says which contact it is: a warm start follows it.
   Up to STICTION_S contacts of a scene may have a surface. With rows for spin or roll all of them have one, whose coefficients
   are lengths, and STICTION_S is as large as STICTION_C. */
#if STICTION_D <= 3
enum stiction_status stiction_add_contact(stiction *s, const stiction_real jacobian[STICTION_D][STICTION_N],
                                          const stiction_real offset[STICTION_D], stiction_real mu, uint32_t key);
#endif
enum stiction_status stiction_add_contact_on(stiction *s, const stiction_real jacobian[STICTION_D][STICTION_N],
                                             const stiction_real offset[STICTION_D], const stiction_surface *surface,
                                             uint32_t key);

/* The index of the first contact with this key, or a status below 0. An index is the place in the order they were added, from 0; all calls
   that change or remove a contact take it. */
int32_t stiction_contact_index(const stiction *s, uint32_t key);

/* Removes a contact. The index of each later one falls by one. */
enum stiction_status stiction_remove_contact(stiction *s, uint32_t contact);

/* The same contacts with other numbers. Offset and friction cost nothing; after M or a
   Jacobian has changed the next solve factorises first. Of a surface `mu` is the larger coefficient of the tangents, which scales
   the others with it. */
enum stiction_status stiction_set_jacobian(stiction *s, uint32_t contact, const stiction_real jacobian[STICTION_D][STICTION_N]);
enum stiction_status stiction_set_offset(stiction *s, uint32_t contact, const stiction_real offset[STICTION_D]);
enum stiction_status stiction_set_friction(stiction *s, uint32_t contact, stiction_real mu);

/* Joint rows: the same in the same way. Offset and law cost nothing; after a Jacobian or a compliance has changed the next solve
   factorises first. `lower` and `upper` (N s or N m s) count for STICTION_BOX alone. */
enum stiction_status stiction_add_row(stiction *s, const stiction_joint_row *row);
int32_t stiction_row_index(const stiction *s, uint32_t key);
enum stiction_status stiction_remove_row(stiction *s, uint32_t row);
enum stiction_status stiction_set_row_jacobian(stiction *s, uint32_t row, const stiction_real jacobian[STICTION_N]);
enum stiction_status stiction_set_row_offset(stiction *s, uint32_t row, stiction_real offset);
enum stiction_status stiction_set_row_law(stiction *s, uint32_t row, enum stiction_law law, stiction_real lower,
                                          stiction_real upper);
enum stiction_status stiction_set_row_compliance(stiction *s, uint32_t row, stiction_real compliance);

/* Starts the next solve at these impulses, in place of the last solution. What is missing starts at 0, what is outside of its cone
   or its bounds is projected, and impulses that are worse than none are ignored. A list of none may be null. */
enum stiction_status stiction_set_impulses(stiction *s, const stiction_contact_impulse *contacts, uint32_t contact_count,
                                           const stiction_row_impulse *rows, uint32_t row_count);

/* The largest budget with which a call takes at most so many microseconds at a clock of so many megahertz, in float on a Cortex-M4F with
   all velocities, contacts and joint rows in use: preparing included, filling and the passes of limits not. wait_percent: cycles in which
   the core waits for its memory, as a share of those in which it works (0, or 55 with five wait states of the flash and no cache).
   0 if there is not enough time, and always for double. */
uint32_t stiction_budget_within(uint32_t microseconds, uint32_t megahertz, uint32_t wait_percent);

/* Solves for a free impulse M v_free (N s) to an error of `tolerance`; 1e-4 suits float. A call does at most `budget` work
   and 19 more: a Newton step counts 10, a sweep 2. If the budget has ended, resume goes on, with the same scene, free impulse and
   tolerance, and in how many calls makes no difference, except that STICTION_INFEASIBLE and STICTION_JAMMED may come sooner. Otherwise, and with
   anything else, resume solves. */
enum stiction_status stiction_solve(stiction *s, const stiction_real free_impulse[STICTION_N], stiction_real tolerance,
                                    uint32_t budget);
enum stiction_status stiction_resume(stiction *s, const stiction_real free_impulse[STICTION_N], stiction_real tolerance,
                                     uint32_t budget);

/* The same in small pieces, for a task below the control loop: works for `budget` on a solve, and writes no solution before its end,
   which would take longer than a small budget. Returns STICTION_UNSOLVED until then. A budget of 0 counts as 1. When time is over
   stiction_resume with a budget of 0 writes down the best so far. */
enum stiction_status stiction_advance(stiction *s, const stiction_real free_impulse[STICTION_N], stiction_real tolerance,
                                      uint32_t budget);

/* Solves with as many of these limits as are reached, at most STICTION_L of them: joint rows of STICTION_LIMIT that are not added to the
   scene, each with a key of its own. Those that are reached take rows behind those of the scene, up to STICTION_R in all; they stand in
   the solution behind them, and what does not stand there does not push. Solutions are those of a scene with all of the limits, but for
   STICTION_OUT_OF_ROWS; a call
   with an error may have left STICTION_UNSOLVED in place of the last solution. A list of none may be null. Resume and advance are as without
   limits: those that the paused solve has reached have to be in the list as they were. */
enum stiction_status stiction_solve_with_limits(stiction *s, const stiction_joint_row *limits, uint32_t limit_count,
                                                const stiction_real free_impulse[STICTION_N], stiction_real tolerance,
                                                uint32_t budget);
enum stiction_status stiction_resume_with_limits(stiction *s, const stiction_joint_row *limits, uint32_t limit_count,
                                                 const stiction_real free_impulse[STICTION_N], stiction_real tolerance,
                                                 uint32_t budget);
enum stiction_status stiction_advance_with_limits(stiction *s, const stiction_joint_row *limits, uint32_t limit_count,
                                                  const stiction_real free_impulse[STICTION_N], stiction_real tolerance,
                                                  uint32_t budget);

/* May the last solution be used? It is solved, or the budget or the number type ended it at an error of at most `error`. If
   not, use the impulses of an earlier tick. After a solve with an error the last solution is that of an earlier tick. */
bool stiction_is_usable(const stiction *s, stiction_real error);

/* Copies the last solution. Contacts from `count` on and rows from `row_count` on are zero. */
enum stiction_status stiction_read(const stiction *s, stiction_solution *solution);

/* Copies one contact or one joint row of the last solution: by its index, or the first with this key. If there is none, nothing is
   written. */
enum stiction_status stiction_contact_at(const stiction *s, uint32_t contact, stiction_contact *found);
enum stiction_status stiction_contact_by_key(const stiction *s, uint32_t key, stiction_contact *found);
enum stiction_status stiction_row_at(const stiction *s, uint32_t row, stiction_row *found);
enum stiction_status stiction_row_by_key(const stiction *s, uint32_t key, stiction_row *found);

/* How far the last solution is from what contacts and joint rows allow, in the units of the scene. Before they change. */
enum stiction_status stiction_worst_violation(const stiction *s, stiction_violation *violation);

/* Of all impulses that obey the law with the velocity of the last solution, those of springs of equal stiffness: unique, and the same whatever
   came before. Copies the last solution with them; `error` is the share of the momentum that they miss, at most `tolerance` if rounding
   allows that. STICTION_NO_SOLUTION if the last solution has a larger error than `tolerance`, or is not that of the scene as it is now
   (reached limits are not in the scene); STICTION_STALE_FACTOR if that has changed since. */
enum stiction_status stiction_read_least(const stiction *s, stiction_real tolerance, stiction_solution *solution);

/* How near to slipping the last solution is, to a relative `accuracy` (0.01 suits float). slip_reserve: the least share of the friction of all
   that sticks with which it still sticks; 0.8, and a fifth may go. load_reserve: the largest factor on a further impulse `load` with which
   all that sticks still sticks, by the convex relaxation: Coulomb's law may let go earlier; INFINITY if nothing lets go. rest_reserve asks for no
   solution: the least share of friction with which all could stay at rest under a free impulse; above 1 something slides, INFINITY if
   something tips or falls. */
enum stiction_status stiction_slip_reserve(const stiction *s, stiction_real accuracy, stiction_real *share);
enum stiction_status stiction_load_reserve(const stiction *s, const stiction_real load[STICTION_N], stiction_real accuracy,
                                           stiction_real *factor);
enum stiction_status stiction_rest_reserve(stiction *s, const stiction_real free_impulse[STICTION_N], stiction_real accuracy,
                                           stiction_real *share);

/* What the last error was about, of a call that may change or solve something. Null pointers are not remembered. */
enum stiction_status stiction_last_culprit(const stiction *s, stiction_culprit *culprit);

/* The last error in words, at most `bytes` with the zero at the end; some KB of flash if it is called. */
enum stiction_status stiction_describe(const stiction *s, char *text, size_t bytes);

/* The name of a status, "STICTION_SOLVED"; "?" of any other number. */
const char *stiction_name(int32_t status);

#ifdef __cplusplus
}
#endif

#endif
