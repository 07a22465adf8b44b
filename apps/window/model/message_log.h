#pragma once

#include <cstddef>
#include <deque>
#include <string>

namespace aula {

/// The newest messages for the user. [one thread]
class MessageLog {
 public:
    static constexpr std::size_t kMaxMessages = 5;

    struct Message {
        std::string text;
        bool is_error = false;
        double time_s = 0;  ///< by the window's clock
    };

    /// Sets the time of the messages that follow.
    void set_time(double now_s) { now_s_ = now_s; }

    /// Adds a message. Of more than kMaxMessages the oldest is dropped.
    void say(std::string text, bool is_error = false);

    /// Removes the errors whose text contains `about`.
    void remove_errors(const std::string& about);

    /// The oldest first.
    const std::deque<Message>& messages() const { return messages_; }

 private:
    std::deque<Message> messages_;
    double now_s_ = 0;
};

}  // namespace aula
