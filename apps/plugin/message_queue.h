#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "aula/audio/realtime.h"

namespace aula::plugin {

/// Texts of a plugin that a host sees or sets.
enum class Property : std::size_t { scene, hrtf, status };
inline constexpr std::size_t kProperties = 3;

/// A property's text, in a buffer of fixed size.
struct Message {
    static constexpr std::size_t kLongest = 4095;  ///< bytes; a path's limit (PATH_MAX)

    Property property = Property::scene;
    std::size_t size = 0;
    std::array<char, kLongest + 1> text{};  ///< ends with a zero

    std::string_view view() const { return {text.data(), size}; }

    /// Longer texts are cut.
    void set(Property new_property, std::string_view new_text) noexcept AULA_NONBLOCKING {
        property = new_property;
        size = new_text.size() < kLongest ? new_text.size() : kLongest;
        std::memcpy(text.data(), new_text.data(), size);
        text[size] = 0;
    }
};

/// Messages from one thread to another in their order. Wait-free.
class MessageQueue {
 public:
    /// False if the queue is full. [writer thread]
    bool push(Property property, std::string_view text) noexcept AULA_NONBLOCKING {
        const std::size_t written = written_.load(std::memory_order_relaxed);
        if (written - read_.load(std::memory_order_acquire) == messages_->size()) return false;
        (*messages_)[written % messages_->size()].set(property, text);
        written_.store(written + 1, std::memory_order_release);
        return true;
    }

    /// The oldest message, until pop(); null if there is none. [reader thread]
    const Message* front() const noexcept AULA_NONBLOCKING {
        const std::size_t read = read_.load(std::memory_order_relaxed);
        if (read == written_.load(std::memory_order_acquire)) return nullptr;
        return &(*messages_)[read % messages_->size()];
    }
    void pop() noexcept AULA_NONBLOCKING {
        read_.store(read_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
    }

 private:
    static constexpr std::size_t kCapacity = 16;
    std::unique_ptr<std::array<Message, kCapacity>> messages_ =
        std::make_unique<std::array<Message, kCapacity>>();
    std::atomic<std::size_t> written_ = 0;
    std::atomic<std::size_t> read_ = 0;
};

}  // namespace aula::plugin
