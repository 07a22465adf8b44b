#pragma once

#include <memory>

namespace aula::test {

/// A client of the JACK server with one output, "player:out", that rises from 0 to `peak` in each
/// block.
class JackSender {
 public:
    explicit JackSender(float peak);
    ~JackSender();
    JackSender(const JackSender&) = delete;
    JackSender& operator=(const JackSender&) = delete;

    /// Connects the output to an input. False if there is no such input.
    bool connect(const char* input);

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula::test
