#pragma once

#include <memory>
#include <string>
#include <vector>

namespace aula::test {

/// A client of the JACK server with one input, which others see as an output device of that name.
/// Records 0.5 s from the first sample that is not zero.
class JackReceiver {
 public:
    static constexpr unsigned kMinLatency = 100;  ///< of its input, in samples
    static constexpr unsigned kMaxLatency = 300;

    explicit JackReceiver(const std::string& name);
    ~JackReceiver();
    JackReceiver(const JackReceiver&) = delete;
    JackReceiver& operator=(const JackReceiver&) = delete;

    /// True once 0.5 s are recorded.
    bool full() const;

    /// The recording; valid once full().
    const std::vector<float>& samples() const;

    /// True if the server has reported no overrun.
    bool in_time() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

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
