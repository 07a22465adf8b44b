#include <windows.h>

#include <stdexcept>

#include "tests/plugin/editor/host_window.h"

namespace aula::test {

namespace {

HWND window(std::uintptr_t number) { return reinterpret_cast<HWND>(number); }

void send(DWORD flags, Pixel at = {}) {
    INPUT input{};
    input.type = INPUT_MOUSE;
    input.mi.dwFlags = flags;
    // 65536 units across, those of a pixel from its left on.
    input.mi.dx = (at.x * 65536 + 32768) / GetSystemMetrics(SM_CXSCREEN);
    input.mi.dy = (at.y * 65536 + 32768) / GetSystemMetrics(SM_CYSCREEN);
    if (SendInput(1, &input, sizeof(input)) != 1) throw std::runtime_error("no mouse");
}

}  // namespace

HostWindow::HostWindow(unsigned width, unsigned height)
    : width_(width), height_(height), display_(GetDC(nullptr)) {
    window_ = reinterpret_cast<std::uintptr_t>(CreateWindowExA(
        WS_EX_TOPMOST, "STATIC", "host", WS_POPUP | WS_VISIBLE | WS_CLIPCHILDREN, 0, 0,
        static_cast<int>(width), static_cast<int>(height), nullptr, nullptr, nullptr, nullptr));
    if (window_ == 0) throw std::runtime_error("no window");
    dispatch();
}

HostWindow::~HostWindow() {
    DestroyWindow(window(window_));
    ReleaseDC(nullptr, static_cast<HDC>(display_));
    dispatch();
}

std::vector<std::uint32_t> HostWindow::pixels() const {
    const auto screen = static_cast<HDC>(display_);
    BITMAPINFO format{};
    format.bmiHeader.biSize = sizeof(format.bmiHeader);
    format.bmiHeader.biWidth = static_cast<LONG>(width_);
    format.bmiHeader.biHeight = -static_cast<LONG>(height_);  // the upper row first
    format.bmiHeader.biPlanes = 1;
    format.bmiHeader.biBitCount = 32;
    format.bmiHeader.biCompression = BI_RGB;
    void* shades = nullptr;
    HDC picture = CreateCompatibleDC(screen);
    HBITMAP bitmap = CreateDIBSection(screen, &format, DIB_RGB_COLORS, &shades, nullptr, 0);
    if (bitmap == nullptr) throw std::runtime_error("no picture");
    HGDIOBJ before = SelectObject(picture, bitmap);
    BitBlt(picture, 0, 0, static_cast<int>(width_), static_cast<int>(height_), screen, 0, 0,
           SRCCOPY);
    GdiFlush();
    const auto* const first = static_cast<const std::uint32_t*>(shades);
    std::vector<std::uint32_t> pixels(first, first + std::size_t{width_} * height_);
    for (std::uint32_t& pixel : pixels) pixel &= 0xFFFFFF;
    SelectObject(picture, before);
    DeleteObject(bitmap);
    DeleteDC(picture);
    return pixels;
}

void HostWindow::dispatch() {
    MSG message;
    while (PeekMessage(&message, nullptr, 0, 0, PM_REMOVE) != 0) {
        TranslateMessage(&message);
        DispatchMessage(&message);
    }
}

void HostWindow::move_mouse(Pixel to) { send(MOUSEEVENTF_MOVE | MOUSEEVENTF_ABSOLUTE, to); }

void HostWindow::press(bool is_down) { send(is_down ? MOUSEEVENTF_LEFTDOWN : MOUSEEVENTF_LEFTUP); }

}  // namespace aula::test
