#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

#include "audio/realtime.h"

namespace aula {

/// Hands values of one writer thread to one reader thread, lock-free: the newest wins, and
/// ownership of what was replaced or spent comes back to the writer, who fills it again. Neither
/// side waits; the reader neither allocates nor frees. At most `kCapacity` values circulate.
template <typename T>
class Mailbox {
   public:
    static constexpr std::size_t kCapacity = 8;

    Mailbox() = default;
    Mailbox(const Mailbox&) = delete;
    Mailbox& operator=(const Mailbox&) = delete;
    ~Mailbox();

    /// Publishes a value; one that was published before and not yet taken goes to the spent ones.
    /// [writer thread]
    void publish(std::unique_ptr<T> value);

    /// A spent value to be filled again, or null. [writer thread]
    std::unique_ptr<T> reclaim();

    /// The newest value, or null if there is none since the last call. [reader thread, wait-free]
    T* take() noexcept AULA_NONBLOCKING;

    /// Gives a value that take() returned back to the writer. [reader thread, wait-free]
    void give_back(T* value) noexcept AULA_NONBLOCKING;
};

}  // namespace aula
