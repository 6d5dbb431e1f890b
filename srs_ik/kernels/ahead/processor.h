/* Whether this machine has what x86-64-v3 means: read from the processor, as not every compiler's own check works. */
#if defined(__x86_64__)
#include <cpuid.h>
#include <stdbool.h>

static inline bool has_x86_64_v3(void) {
    const unsigned first = 1u << 12 | 1u << 22 | 1u << 27 | 1u << 28 | 1u << 29; /* FMA MOVBE OSXSAVE AVX F16C */
    const unsigned second = 1u << 3 | 1u << 5 | 1u << 8;                         /* BMI AVX2 BMI2 */
    const unsigned third = 1u << 5;                                              /* LZCNT */
    unsigned a, b, c, d, low, high;
    if (!__get_cpuid(1, &a, &b, &c, &d) || (c & first) != first) return false;
    __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    if ((low & 6) != 6) return false;
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d) || (b & second) != second) return false;
    return __get_cpuid(0x80000001, &a, &b, &c, &d) && (c & third) == third;
}
#endif
