/* What machine code of kernels wants around it, once in a library: what systems do differently, the choice of a level.
 *
 * kernels.h is written by the build: the kernels of every level of processors, the best first, and their tables. */
#include <stdint.h>
#include <stdlib.h>

#define ALIGNMENT 64 /* bytes: of a cache line */

/* EXPORT: a function that users see; HIDDEN: what other objects of this library see; take: memory at a multiple of
 * ALIGNMENT, of a size that is one; give: it goes back. */
#ifdef _WIN32
#include <malloc.h>
#define EXPORT __declspec(dllexport)
#define HIDDEN
#define take(size) _aligned_malloc(size, ALIGNMENT)
#define give _aligned_free
#else
#define EXPORT __attribute__((visibility("default")))
#define HIDDEN __attribute__((visibility("hidden")))
#define take(size) aligned_alloc(ALIGNMENT, size)
#define give free
#endif

/* An address in 64 bits, also where pointers are shorter: so kernels read them (wrsim.jit.stages). */
struct word {
    _Alignas(8) const void *address;
};

#include "kernels.h"

#ifndef LEVEL
#define LEVEL level
static int level; /* of the kernels that this processor runs */

#if LEVELS > 1
#include <cpuid.h>

/* Whether processor and system have what x86-64-v3 asks for. */
static int has_v3(void)
{
    const unsigned first = bit_FMA | bit_MOVBE | bit_OSXSAVE | bit_AVX | bit_F16C, seventh = bit_AVX2 | bit_BMI | bit_BMI2;
    unsigned a, b, c, d;
    if (!__get_cpuid(1, &a, &b, &c, &d) || (c & first) != first) return 0;
    __asm__("xgetbv" : "=a"(a), "=d"(d) : "c"(0));
    if ((a & 6) != 6) return 0; /* the system keeps no long registers */
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d) || (b & seventh) != seventh) return 0;
    return __get_cpuid(0x80000001, &a, &b, &c, &d) && c & bit_LZCNT;
}

__attribute__((constructor)) static void choose_level(void) { level = !has_v3(); }
#endif
#endif

/* Run a kernel in a workspace; a status, or ``failed`` where it ended early. */
static int64_t run(int kernel, double *buffer, int64_t doubles, const int64_t *index, int64_t rows, int64_t failed)
{
    int64_t status = 0;
    void *problem = NULL;
    if (kernels[LEVEL][kernel](&status, &problem, NULL, NULL, doubles, 8, buffer, doubles, 8, NULL, NULL, rows * 4, 8,
                               (int64_t *)index, rows, 4, 32, 8) != 0)
        return failed;
    return status;
}
