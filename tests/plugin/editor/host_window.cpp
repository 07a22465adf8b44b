#include "tests/plugin/editor/host_window.h"

#include <X11/Xlib.h>
#include <X11/Xutil.h>

#include <cstdlib>
#include <set>
#include <stdexcept>
#include <string>

#include "tests/support/program.h"

namespace aula::test {

namespace {

::Display* x11(void* display) { return static_cast<::Display*>(display); }

bool is_near(std::uint32_t pixel, const std::array<int, 3>& colour) {
    constexpr int kTolerance = 8;  // of a rounded mean of drawn and background at an edge
    for (std::size_t c = 0; c < 3; ++c) {
        const int shade = static_cast<int>(pixel >> (16 - 8 * c) & 0xFF);
        if (std::abs(shade - colour[c]) > kTolerance) return false;
    }
    return true;
}

}  // namespace

HostWindow::HostWindow(unsigned width, unsigned height)
    : width_(width), height_(height), display_(XOpenDisplay(nullptr)) {
    if (display_ == nullptr) throw std::runtime_error("no display");
    XSetWindowAttributes attributes{};
    attributes.override_redirect = True;
    window_ = XCreateWindow(x11(display_), DefaultRootWindow(x11(display_)), 0, 0, width, height, 0,
                            CopyFromParent, InputOutput, nullptr, CWOverrideRedirect, &attributes);
    XMapRaised(x11(display_), window_);
    XSync(x11(display_), False);
}

HostWindow::~HostWindow() {
    XDestroyWindow(x11(display_), window_);
    XCloseDisplay(x11(display_));
}

std::vector<std::uint32_t> HostWindow::pixels() const {
    XImage* const image = XGetImage(x11(display_), DefaultRootWindow(x11(display_)), 0, 0, width_,
                                    height_, AllPlanes, ZPixmap);
    if (image == nullptr) throw std::runtime_error("no picture");
    std::vector<std::uint32_t> pixels;
    for (unsigned y = 0; y < height_; ++y)
        for (unsigned x = 0; x < width_; ++x)
            pixels.push_back(static_cast<std::uint32_t>(
                XGetPixel(image, static_cast<int>(x), static_cast<int>(y)) & 0xFFFFFF));
    XDestroyImage(image);
    return pixels;
}

std::optional<Pixel> HostWindow::mark(const std::array<int, 3>& colour) const {
    constexpr int kSize = 24;  // of a mark at most
    const std::vector<std::uint32_t> all = pixels();
    const int width = static_cast<int>(width_);
    std::optional<Pixel> first;
    std::array<long, 3> sum{};
    for (int y = 0; y < static_cast<int>(height_); ++y) {
        for (int x = 0; x < width; ++x) {
            if (!is_near(all[static_cast<std::size_t>(y * width + x)], colour)) continue;
            if (!first) first = Pixel{x, y};
            if (y - first->y > kSize || std::abs(x - first->x) > kSize) continue;
            sum[0] += x;
            sum[1] += y;
            ++sum[2];
        }
    }
    if (!first) return std::nullopt;
    return Pixel{static_cast<int>(sum[0] / sum[2]), static_cast<int>(sum[1] / sum[2])};
}

std::size_t HostWindow::colours() const {
    std::set<std::uint32_t> found;
    for (const std::uint32_t pixel : pixels())
        if (found.size() < 1000) found.insert(pixel);
    return found.size();
}

void HostWindow::move_mouse(Pixel to) {
    run_program({"xdotool", "mousemove", std::to_string(to.x), std::to_string(to.y)});
}

void HostWindow::press(bool is_down) {
    run_program({"xdotool", is_down ? "mousedown" : "mouseup", "1"});
}

}  // namespace aula::test
