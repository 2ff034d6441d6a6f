/* The sizes of a scene: the one place where they are chosen. C includes this file, and lib.rs reads it as it is compiled.
   One line for each number. */
#ifndef STICTION_SIZES_H
#define STICTION_SIZES_H

#define STICTION_REAL float /* the number type: float or double */
#define STICTION_N 18       /* generalised velocities */
#define STICTION_D 3        /* rows of a contact: 1 frictionless, 2 planar, 3 spatial, 4 and spin, 6 and roll */
#define STICTION_C 5        /* most contacts */
#define STICTION_R 0        /* most joint rows: stops, motors, dry friction; 0 takes neither memory nor time */
#define STICTION_S 0        /* most contacts with a surface; 0 takes neither memory nor time */
#define STICTION_L 0        /* limits that stiction_solve_with_limits leaves out until they are reached; they take stack in that call */

/* What the solver goes through: AllPhases, SweepsAndNewton or SweepsOnly, in names of Rust. Each takes less flash than the one before
   and solves fewer scenes within a budget; only the first proves that a scene is infeasible or jammed. */
#define STICTION_PHASES AllPhases

/* Bytes of one `stiction`. If they are too few, or more than a quarter too many, the build of the library ends with the number to
   write here, and `make` writes it. A 64-bit machine, where `make test` runs, needs a few more than a microcontroller. */
#define STICTION_BYTES 9208

#endif
