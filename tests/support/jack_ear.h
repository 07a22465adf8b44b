#pragma once

#include <memory>
#include <string>
#include <vector>

namespace aula::test {

/// A client of the JACK server with one input: to others an output device of that name. Keeps half
/// a second of what it is sent, from the first sample on that is not zero.
class JackEar {
 public:
    explicit JackEar(const std::string& name);
    ~JackEar();
    JackEar(const JackEar&) = delete;
    JackEar& operator=(const JackEar&) = delete;

    bool full() const;

    /// What was kept, once it is full.
    const std::vector<float>& samples() const;

    /// Whether the server was in time, by its own word.
    bool in_time() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula::test
