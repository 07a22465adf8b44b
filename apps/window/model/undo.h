#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace aula {

/// A value with its history for undo and redo, limited to kMaxSteps values.
template <typename T>
class Undo {
 public:
    static constexpr std::size_t kMaxSteps = 100;

    explicit Undo(T value) { values_.push_back(std::make_shared<const T>(std::move(value))); }

    const T& now() const { return *values_[at_]; }

    /// Appends a new value; discards the values that redo would restore.
    void change(T value) {
        values_.resize(at_ + 1);
        values_.push_back(std::make_shared<const T>(std::move(value)));
        if (values_.size() > kMaxSteps) values_.erase(values_.begin());
        at_ = values_.size() - 1;
    }

    bool can_undo() const { return at_ > 0; }
    bool can_redo() const { return at_ + 1 < values_.size(); }
    void undo() { at_ -= can_undo() ? 1 : 0; }
    void redo() { at_ += can_redo() ? 1 : 0; }

    /// Replaces the value and clears the history.
    void restart(T value) { *this = Undo(std::move(value)); }

 private:
    std::vector<std::shared_ptr<const T>> values_;
    std::size_t at_ = 0;
};

}  // namespace aula
