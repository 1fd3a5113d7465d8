#include "watch.h"

#include <algorithm>
#include <atomic>

// The sanitizers' allocator, of clang and of gcc alike; elsewhere null.
extern "C" {
__attribute__((weak)) int __sanitizer_install_malloc_and_free_hooks(void (*taken)(const volatile void*, std::size_t),
                                                                    void (*given)(const volatile void*));
__attribute__((weak)) std::size_t __sanitizer_get_current_allocated_bytes();
}

namespace plumb::fuzz {
namespace {

enum class Counting { off, sum, peak };
std::atomic<Counting> counting{Counting::off};
std::atomic<std::size_t> counted{0};

void taken(const volatile void*, std::size_t size) {
    switch (counting.load(std::memory_order_relaxed)) {
        case Counting::off: return;
        case Counting::sum: counted.fetch_add(size, std::memory_order_relaxed); return;
        case Counting::peak: {
            const std::size_t now = __sanitizer_get_current_allocated_bytes();
            std::size_t most = counted.load(std::memory_order_relaxed);
            while (now > most && !counted.compare_exchange_weak(most, now, std::memory_order_relaxed)) {}
        }
    }
}
void given(const volatile void*) {}

std::size_t run_counting(Counting how, Target run, const std::uint8_t* data, std::size_t size) {
    struct Stop {
        ~Stop() { counting = Counting::off; }
    } stop;
    counting = how;
    return run(data, size);
}

}  // namespace

Watched watch(const Format& format, const std::uint8_t* data, std::size_t size) {
    static const bool counts = __sanitizer_install_malloc_and_free_hooks && __sanitizer_get_current_allocated_bytes &&
                               __sanitizer_install_malloc_and_free_hooks(taken, given) != 0;
    if (!counts) return {format.run(data, size), 0, true};
    const auto within = [&](const Watched& w) { return w.peak <= memory_factor * w.need + format.slack; };
    counted = 0;
    Watched watched;
    watched.need = run_counting(Counting::sum, format.run, data, size);
    watched.peak = counted;
    watched.within = within(watched);
    if (watched.within) return watched;

    // To ask for what is in use at each allocation is exact and slow.
    const std::size_t before = __sanitizer_get_current_allocated_bytes();
    counted = before;
    watched.need = run_counting(Counting::peak, format.run, data, size);
    watched.peak = counted - std::min<std::size_t>(before, counted);
    watched.within = within(watched);
    return watched;
}

}  // namespace plumb::fuzz
