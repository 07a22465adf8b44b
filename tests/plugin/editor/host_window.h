#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace aula::test {

/// A pixel of a screen, from its upper left corner.
struct Pixel {
    int x = 0;
    int y = 0;
};

/// A window of a host on the display of the environment, at the upper left corner, for editors.
class HostWindow {
 public:
    HostWindow(unsigned width, unsigned height);
    ~HostWindow();
    HostWindow(const HostWindow&) = delete;
    HostWindow& operator=(const HostWindow&) = delete;

    std::uintptr_t number() const { return window_; }

    /// The middle of the uppermost mark of a colour in the window.
    std::optional<Pixel> mark(const std::array<int, 3>& colour) const;
    /// Colours that differ, up to 1000.
    std::size_t colours() const;

    /// Handles the messages of the window system, where that is the host's part.
    static void dispatch();

    // Events as those of a mouse.
    static void move_mouse(Pixel to);
    static void press(bool is_down);

 private:
    /// Of the screen, 0xRRGGBB, row by row.
    std::vector<std::uint32_t> pixels() const;

    unsigned width_;
    unsigned height_;
    void* display_;
    std::uintptr_t window_ = 0;
};

}  // namespace aula::test
