// Drags a file onto a window of the X display and drops it, by the protocol XDND 5.
// Usage: drop_file WINDOW FILE TITLE. WINDOW and TITLE are parts of the window's titles before and
// after. Exit: 0 when the window has accepted the file and has the title TITLE, else 1.

#include <X11/Xatom.h>
#include <X11/Xlib.h>

#include <cctype>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <functional>
#include <string>
#include <thread>

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds kLongest{60};

/// "file:///a%20b" of a path.
std::string uri_of(const std::string& path) {
    std::string uri = "file://";
    for (const char c : path) {
        const auto byte = static_cast<unsigned char>(c);
        char text[4] = {c, '\0'};
        if (std::isalnum(byte) == 0 && std::strchr("/._-", c) == nullptr)
            std::snprintf(text, sizeof text, "%%%02X", byte);
        uri += text;
    }
    return uri;
}

class Drag {
 public:
    explicit Drag(Display* display)
        : display_(display),
          source_(XCreateSimpleWindow(display, DefaultRootWindow(display), 0, 0, 1, 1, 0, 0, 0)) {}

    bool find(const std::string& title) {
        return wait(
            [&] { return (target_ = find_below(DefaultRootWindow(display_), title)) != None; });
    }

    bool has_title(const std::string& title) {
        return wait([&] { return title_of(target_).find(title) != std::string::npos; });
    }

    /// Returns whether the window has accepted the file.
    bool drop(const std::string& file) {
        const std::string uri = uri_of(file) + "\r\n";
        XSetSelectionOwner(display_, atom("XdndSelection"), source_, CurrentTime);
        send("XdndEnter", 5L << 24, static_cast<long>(atom("text/uri-list")), 0, 0);
        constexpr long kPlace = 300L << 16 | 300;
        send("XdndPosition", 0, kPlace, CurrentTime, static_cast<long>(atom("XdndActionCopy")));
        bool accepted = false;
        bool finished = false;
        wait([&] {
            while (XPending(display_) > 0) {
                XEvent event;
                XNextEvent(display_, &event);
                if (event.type == SelectionRequest) answer(event.xselectionrequest, uri);
                if (event.type != ClientMessage) continue;
                const XClientMessageEvent& message = event.xclient;
                if (message.message_type == atom("XdndFinished")) {
                    finished = true;
                    accepted = message.data.l[1] != 0;  // GLFW: the size of what it has read
                } else if (message.message_type == atom("XdndStatus")) {
                    if ((message.data.l[1] & 1) == 0) return true;
                    send("XdndDrop", 0, CurrentTime, 0, 0);
                }
            }
            return finished;
        });
        return accepted;
    }

 private:
    template <typename Condition>
    static bool wait(const Condition& holds) {
        for (const auto end = Clock::now() + kLongest; Clock::now() < end;) {
            if (holds()) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        return false;
    }

    Atom atom(const char* name) const { return XInternAtom(display_, name, False); }

    std::string title_of(Window window) const {
        Atom type = None;
        int format = 0;
        unsigned long count = 0;
        unsigned long left = 0;
        unsigned char* bytes = nullptr;
        XGetWindowProperty(display_, window, atom("_NET_WM_NAME"), 0, 1024, False, AnyPropertyType,
                           &type, &format, &count, &left, &bytes);
        if (bytes == nullptr) return "";
        std::string title(reinterpret_cast<const char*>(bytes), count);
        XFree(bytes);
        return title;
    }

    Window find_below(Window parent, const std::string& title) const {
        if (title_of(parent).find(title) != std::string::npos) return parent;
        Window root = None;
        Window of = None;
        Window* children = nullptr;
        unsigned count = 0;
        if (XQueryTree(display_, parent, &root, &of, &children, &count) == 0) return None;
        Window found = None;
        for (unsigned i = 0; i < count && found == None; ++i)
            found = find_below(children[i], title);
        if (children != nullptr) XFree(children);
        return found;
    }

    void send(const char* type, long a, long b, long c, long d) {
        XEvent event{};
        event.xclient.type = ClientMessage;
        event.xclient.window = target_;
        event.xclient.message_type = atom(type);
        event.xclient.format = 32;
        const long values[] = {static_cast<long>(source_), a, b, c, d};
        std::memcpy(event.xclient.data.l, values, sizeof values);
        XSendEvent(display_, target_, False, NoEventMask, &event);
        XFlush(display_);
    }

    void answer(const XSelectionRequestEvent& request, const std::string& text) {
        XChangeProperty(display_, request.requestor, request.property, request.target, 8,
                        PropModeReplace, reinterpret_cast<const unsigned char*>(text.data()),
                        static_cast<int>(text.size()));
        XEvent event{};
        event.xselection.type = SelectionNotify;
        event.xselection.requestor = request.requestor;
        event.xselection.selection = request.selection;
        event.xselection.target = request.target;
        event.xselection.property = request.property;
        event.xselection.time = request.time;
        XSendEvent(display_, request.requestor, False, NoEventMask, &event);
        XFlush(display_);
    }

    Display* display_;
    Window source_;
    Window target_ = None;
};

}  // namespace

int main(int count, char** arguments) {
    // Windows may close while they are looked at.
    XSetErrorHandler([](Display*, XErrorEvent*) { return 0; });
    Display* const display = XOpenDisplay(nullptr);
    if (count != 4 || display == nullptr) return 1;
    Drag drag(display);
    const char* problem = !drag.find(arguments[1])        ? "no such window"
                          : !drag.drop(arguments[2])      ? "the window does not accept the file"
                          : !drag.has_title(arguments[3]) ? "the window does not show the file"
                                                          : nullptr;
    if (problem != nullptr) std::fprintf(stderr, "drop_file: %s\n", problem);
    XCloseDisplay(display);
    return problem == nullptr ? 0 : 1;
}
