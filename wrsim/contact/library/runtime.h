/* What machine code of kernels wants around it, once in a library.
 *
 * kernels.h is written by the build: the kernels, the table of stages, what the processor must have. */
#include <stdint.h>
#include <stdlib.h>

#include "kernels.h"

#define HIDDEN __attribute__((visibility("hidden")))
#define ALIGNMENT 64 /* bytes: of a cache line */

/* Where compiled kernels find each other (wrsim.jit.stages). */
static void *const stage_table[] = {STAGE_ADDRESSES};
HIDDEN void *const *const STAGE_TABLE_ADDRESS = stage_table;

static int processor_fits(void)
{
#ifdef PROCESSOR_FITS
    __builtin_cpu_init();
    return PROCESSOR_FITS;
#else
    return 1;
#endif
}

/* Run a stage in a workspace; a status, or ``failed`` where it ended early. */
static int64_t run(stage *kernel, double *buffer, int64_t doubles, const int64_t *index, int64_t rows, int64_t failed)
{
    int64_t status = 0;
    void *problem = NULL;
    if (kernel(&status, &problem, NULL, NULL, doubles, 8, buffer, doubles, 8, NULL, NULL, rows * 4, 8, (int64_t *)index,
               rows, 4, 32, 8) != 0)
        return failed;
    return status;
}
