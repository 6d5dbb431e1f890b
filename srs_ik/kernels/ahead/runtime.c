/* What compiled kernels ask of Numba's runtime: reference-counted blocks for their work space. */
#include <pthread.h>
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

/* Large blocks go back to the system when they are freed, and each page of the next one is asked for and cleared anew:
   that would be a fifth of a search. So each thread keeps some for its next calls. */
enum { LARGE = 1 << 12, LARGEST = 1 << 20, KEPT = 16 };

static pthread_key_t key;
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void free_kept(void *made) {
    block **kept = made;
    for (int i = 0; i < KEPT; i++) free(kept[i]);
    free(kept);
}

static void make_key(void) { pthread_key_create(&key, free_kept); }

/* The places of this thread's kept blocks; NULL where there is no memory for them. */
static block **places(void) {
    static _Thread_local block **kept;
    if (kept == NULL) {
        pthread_once(&once, make_key);
        kept = calloc(KEPT, sizeof(block *));
        pthread_setspecific(key, kept);
    }
    return kept;
}

/* A kept block with room for so many bytes and no more than twice as much, else a new one. */
static block *take(size_t room) {
    block **kept = room < LARGE || room > LARGEST ? NULL : places();
    for (int i = 0; kept != NULL && i < KEPT; i++) {
        if (kept[i] != NULL && kept[i]->size >= room && kept[i]->size / 2 <= room) {
            block *found = kept[i];
            kept[i] = NULL;
            return found;
        }
    }
    block *made = malloc(sizeof(block) + room);
    if (made != NULL) made->size = room;
    return made;
}

static void give_back(block *made) {
    block **kept = made->size < LARGE || made->size > LARGEST ? NULL : places();
    for (int i = 0; kept != NULL && i < KEPT; i++) {
        if (kept[i] == NULL) {
            kept[i] = made;
            return;
        }
    }
    free(made);
}

__attribute__((visibility("hidden"))) void *NRT_MemInfo_alloc_aligned(size_t size, uint32_t align) {
    const size_t most = align > ALIGNMENT ? align : ALIGNMENT;
    if (size > SIZE_MAX - sizeof(block) - most) return NULL;
    block *made = take(most + size);
    if (made == NULL) return NULL;
    const uintptr_t behind = (uintptr_t)(made + 1);
    *made = (block){.references = 1, .data = (void *)((behind + most - 1) / most * most), .size = made->size};
    return made;
}

__attribute__((visibility("hidden"))) void *NRT_MemInfo_alloc_safe_aligned(size_t size, uint32_t align) {
    return NRT_MemInfo_alloc_aligned(size, align);
}

__attribute__((visibility("hidden"))) void *NRT_Allocate(size_t size) { return malloc(size); }

__attribute__((visibility("hidden"))) void NRT_Free(void *made) { free(made); }

/* Called by the last one who lets go. */
__attribute__((visibility("hidden"))) void NRT_MemInfo_call_dtor(void *made) { give_back(made); }

/* New strides of an array in C order; arrays in any other order are not reshaped by kernels: 0. */
__attribute__((visibility("hidden"))) int numba_attempt_nocopy_reshape(
    intptr_t axes, const intptr_t *sizes, const intptr_t *strides, intptr_t new_axes, const intptr_t *new_sizes,
    intptr_t *new_strides, intptr_t item, int fortran) {
    intptr_t stride = item;
    for (intptr_t i = axes - 1; i >= 0; i--) {
        if (sizes[i] != 1 && strides[i] != stride) return 0;
        stride *= sizes[i];
    }
    if (fortran) return 0;
    stride = item;
    for (intptr_t i = new_axes - 1; i >= 0; i--) {
        new_strides[i] = stride;
        stride *= new_sizes[i];
    }
    return 1;
}
