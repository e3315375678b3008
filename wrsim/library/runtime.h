/* What machine code of numba's wants around it, once in a library.
 *
 * kernels.h is written by the build: the kernels, the table of stages, what the processor must have. */
#include <stdint.h>
#include <stdlib.h>

#include "kernels.h"

#define HIDDEN __attribute__((visibility("hidden")))
#define ALIGNMENT 64 /* bytes: of a cache line */

/* Where compiled kernels find each other (wrsim.core.jit.stages). */
HIDDEN void *const STAGE_TABLE[STAGES] = {STAGE_ADDRESSES};

/* What numba's code calls where a kernel raises an error; none does, but the linker wants it. Memory is counted
 * as numba counts it, so that the kernel ends with an error of its own. The names of Python belong to the text of that
 * error, which is never put together. */
struct counted {
    size_t references;
    void *unused[2], *data;
    size_t size;
    void *allocator;
};

HIDDEN void *NRT_Allocate(size_t size) { return malloc(size); }

HIDDEN void NRT_Free(void *memory) { free(memory); }

HIDDEN void NRT_MemInfo_call_dtor(struct counted *memory) { free(memory); }

HIDDEN struct counted *NRT_MemInfo_alloc(size_t size)
{
    struct counted *memory = calloc(1, sizeof *memory + size);
    if (memory) *memory = (struct counted){1, {NULL, NULL}, memory + 1, size, NULL};
    return memory;
}

HIDDEN void *PyExc_RuntimeError;
HIDDEN void PyErr_SetString(void *kind, const char *text) { (void)kind, (void)text; }
HIDDEN void *PyUnicode_FromKindAndData(int kind, const void *text, int64_t size) { (void)kind, (void)size; return (void *)text; }
HIDDEN int64_t PyObject_Hash(void *object) { return object == NULL; }
HIDDEN void *PyTuple_Pack(int64_t size, ...) { (void)size; return NULL; }

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
