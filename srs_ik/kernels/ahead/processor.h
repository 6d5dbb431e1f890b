/* Whether this machine has what x86-64-v2, v3 and v4 mean: read from the processor, as not every compiler's own check works. */
#if defined(__x86_64__)
#include <cpuid.h>
#include <stdbool.h>

/* Whether the system keeps registers of some kinds when it changes threads. */
static inline bool keeps(unsigned kinds) {
    unsigned low, high;
    __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return (low & kinds) == kinds;
}

static inline bool has_x86_64_v2(void) {
    const unsigned first = 1u << 0 | 1u << 9 | 1u << 13 | 1u << 19 | 1u << 20 | 1u << 23; /* SSE3 SSSE3 CX16 SSE4 POPCNT */
    unsigned a, b, c, d;
    return __get_cpuid(1, &a, &b, &c, &d) && (c & first) == first;
}

static inline bool has_x86_64_v3(void) {
    const unsigned first = 1u << 12 | 1u << 22 | 1u << 27 | 1u << 28 | 1u << 29; /* FMA MOVBE OSXSAVE AVX F16C */
    const unsigned second = 1u << 3 | 1u << 5 | 1u << 8;                         /* BMI AVX2 BMI2 */
    const unsigned third = 1u << 5;                                              /* LZCNT */
    unsigned a, b, c, d;
    if (!__get_cpuid(1, &a, &b, &c, &d) || (c & first) != first || !keeps(0x6)) return false;
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d) || (b & second) != second) return false;
    return __get_cpuid(0x80000001, &a, &b, &c, &d) && (c & third) == third;
}

static inline bool has_x86_64_v4(void) {
    const unsigned wide = 1u << 16 | 1u << 17 | 1u << 28 | 1u << 30 | 1u << 31; /* AVX-512 F DQ CD BW VL */
    unsigned a, b, c, d;
    return has_x86_64_v3() && keeps(0xe6) && __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & wide) == wide;
}
#endif
