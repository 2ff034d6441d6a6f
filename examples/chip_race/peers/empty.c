/* What the images of the others are compared with: the scene and the text output. */
#define REAL double
#include "race.h"

static void nothing(void) { impulses[0] = push[0] + before[0] + mass[0][0] + jacobian[0][0] + offset[0] + mu[0] + ALPHA; }

int main(void)
{
    setvbuf(stdout, NULL, _IOLBF, 256);
    run("nothing", 0, mallinfo().arena, nothing);
    printf("bytes stack %u\n", stack_bytes(nothing));
    (void)V, (void)q, (void)alpha, (void)prepare_programme, (void)prepare_push, (void)impulse_unit, (void)unit;
    return 0;
}
