#include "apps/window/model/message_log.h"

#include <utility>

namespace aula {

void MessageLog::say(std::string text, bool is_error) {
    messages_.push_back({std::move(text), is_error, now_s_});
    if (messages_.size() > kMaxMessages) messages_.pop_front();
}

void MessageLog::remove_errors(const std::string& about) {
    std::erase_if(messages_, [&](const Message& message) {
        return message.is_error && message.text.find(about) != std::string::npos;
    });
}

}  // namespace aula
