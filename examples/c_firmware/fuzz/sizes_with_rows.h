/* Sizes as in stiction_sizes.h, for rows.rs. */
#define STICTION_REAL double
#define STICTION_N 5
#define STICTION_D 3
#define STICTION_C 3
#define STICTION_R 4
#define STICTION_S 2
#define STICTION_L 3
#define STICTION_PHASES AllPhases
#define STICTION_BYTES 7872
