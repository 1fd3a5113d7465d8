#include "core/large_pages.h"

#if __has_include(<sys/mman.h>)
#include <sys/mman.h>
#endif

namespace plumb {

void prefer_large_pages(void* first, std::size_t bytes) {
#ifdef MADV_HUGEPAGE
    constexpr std::size_t large = std::size_t(2) << 20;
    const std::uintptr_t from = reinterpret_cast<std::uintptr_t>(first), to = from + bytes;
    const std::uintptr_t begin = (from + large - 1) / large * large, end = to / large * large;
    if (begin < end) madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
#else
    (void)first, (void)bytes;
#endif
}

}  // namespace plumb
