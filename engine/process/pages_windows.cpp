#include <windows.h>

#include <new>

#include "process/pages.h"

namespace aula {

// Huge pages need a privilege there that users do not have.
void* map_pages(std::size_t huge_bytes, std::size_t rest_bytes) {
    void* const block =
        VirtualAlloc(nullptr, huge_bytes + rest_bytes, MEM_RESERVE | MEM_COMMIT, PAGE_READWRITE);
    if (block == nullptr) throw std::bad_alloc();
    return block;
}

void unmap_pages(void* begin, std::size_t) noexcept { VirtualFree(begin, 0, MEM_RELEASE); }

}  // namespace aula
