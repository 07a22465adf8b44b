#include "tests/plugin/editor/host_window.h"

#include <X11/Xlib.h>
#include <X11/Xutil.h>

#include <stdexcept>
#include <string>

#include "tests/support/program.h"

namespace aula::test {

namespace {

::Display* x11(void* display) { return static_cast<::Display*>(display); }

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

void HostWindow::move_mouse(Pixel to) {
    run_program({"xdotool", "mousemove", std::to_string(to.x), std::to_string(to.y)});
}

void HostWindow::dispatch() {}

void HostWindow::press(bool is_down) {
    run_program({"xdotool", is_down ? "mousedown" : "mouseup", "1"});
}

}  // namespace aula::test
