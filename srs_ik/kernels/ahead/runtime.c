/* What compiled kernels ask of Numba's runtime: reference-counted blocks for their work space. */
#include <stdint.h>
#include <stdlib.h>

typedef struct {
    size_t references;
    void *destructor, *destructor_info;
    void *data;
    size_t size;
    void *allocator;
} block;

#define ALIGNMENT 32

__attribute__((visibility("hidden"))) void *NRT_MemInfo_alloc_aligned(size_t size, uint32_t align) {
    const size_t most = align > ALIGNMENT ? align : ALIGNMENT;
    if (size > SIZE_MAX - sizeof(block) - most) return NULL;
    block *made = malloc(sizeof(block) + most + size);
    if (made == NULL) return NULL;
    const uintptr_t behind = (uintptr_t)(made + 1);
    *made = (block){.references = 1, .data = (void *)((behind + most - 1) / most * most), .size = size};
    return made;
}

__attribute__((visibility("hidden"))) void *NRT_MemInfo_alloc_safe_aligned(size_t size, uint32_t align) {
    return NRT_MemInfo_alloc_aligned(size, align);
}

__attribute__((visibility("hidden"))) void *NRT_Allocate(size_t size) { return malloc(size); }

__attribute__((visibility("hidden"))) void NRT_Free(void *made) { free(made); }

/* Called by the last one who lets go. */
__attribute__((visibility("hidden"))) void NRT_MemInfo_call_dtor(void *made) { free(made); }
