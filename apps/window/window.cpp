#include "apps/window/window.h"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_opengl3.h>
#include <epoxy/gl.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "apps/window/model/model.h"
#include "apps/window/native_window.h"
#include "apps/window/panels.h"
#include "apps/window/picture.h"
#include "apps/window/screenshot.h"
#include "apps/window/state_file.h"
#include "apps/window/view/layout.h"
#include "aula/audio/realtime.h"
#include "aula/exception.h"

namespace aula {

namespace {

constexpr double kFrame_s = 1.0 / 30;
constexpr double kUnfocusedFrame_s = 1.0 / 6;
constexpr ImGuiPopupFlags kAnyPopup = ImGuiPopupFlags_AnyPopup;
/// Upper limit of the share of a processor that drawing takes.
constexpr double kShare = 0.4;

/// The window's contents and its event loop.
class App {
 public:
    App(const WindowOptions& options, Model& model, const WindowState& state)
        : options_(options),
          model_(model),
          choices_(state.choices),
          native_(state.width, state.height),
          gui_(native_) {
        if (options.screenshot) screenshot_.emplace(*options.screenshot);
    }

    void run() {
        double last_s = glfwGetTime();
        keys_.measure(last_s);
        while (glfwWindowShouldClose(native_.get()) == 0 && !options_.interrupted()) {
            const double begin_s = glfwGetTime();
            const double dt_s = std::min(begin_s - last_s, 0.25);
            last_s = begin_s;
            model_.update(begin_s);
            if (model_.status().finished) return;
            draw(dt_s);
            if (wants_screenshot(begin_s)) {
                write_screenshot(*screenshot_, width_, height_);
                return;
            }
            glfwSwapBuffers(native_.get());
            wait(begin_s);
        }
    }

    WindowState state() const {
        WindowState state;
        if (glfwGetWindowAttrib(native_.get(), GLFW_MAXIMIZED) == 0)
            glfwGetWindowSize(native_.get(), &state.width, &state.height);
        state.choices = choices_;
        return state;
    }

 private:
    bool wants_screenshot(double now_s) const {
        return options_.screenshot && now_s >= options_.screenshot_after_s && !model_.changes() &&
               model_.view();
    }

    /// Handles events until the next frame. The interval is at least that of the frame rate limit,
    /// and at least the drawing time over kShare, which leaves most of the processor to the sound.
    /// Walking continues meanwhile in even steps.
    void wait(double begin_s) {
        constexpr double kStep_s = 1.0 / 60;
        const double cost_s = glfwGetTime() - begin_s;
        const double cap_s =
            native_.is_active() || options_.screenshot ? kFrame_s : kUnfocusedFrame_s;
        const double next_s = begin_s + std::max(cap_s, cost_s / kShare);
        do {
            const double left_s = std::max(0.001, next_s - glfwGetTime());
            glfwWaitEventsTimeout(keys_.any() ? std::min(left_s, kStep_s) : left_s);
            handle_keys();
            walk();
        } while (glfwGetTime() < next_s && glfwWindowShouldClose(native_.get()) == 0);
    }

    /// Walks for the time that keys were held since the last call.
    void walk() {
        if (!keys_.any()) return;
        keys_.measure(glfwGetTime());
        const auto held = [&](int key) { return static_cast<float>(keys_.held_s(key)); };
        const float speed = ImGui::GetIO().KeyShift ? 3.0F : 1.0F;
        WalkInput input;
        input.ahead = speed * (held(GLFW_KEY_W) - held(GLFW_KEY_S));
        input.left = speed * (held(GLFW_KEY_A) - held(GLFW_KEY_D));
        input.turn_left = held(GLFW_KEY_LEFT) - held(GLFW_KEY_RIGHT);
        input.look_up = 0.5F * (held(GLFW_KEY_UP) - held(GLFW_KEY_DOWN));
        model_.walk(input, 1);
    }

    void handle_control_key(int key) {
        if (key == GLFW_KEY_Z) model_.undo();
        if (key == GLFW_KEY_Y) model_.redo();
        if (key == GLFW_KEY_S) model_.save_scene();
        if (key == GLFW_KEY_EQUAL || key == GLFW_KEY_KP_ADD) choices_.larger_text(1);
        if (key == GLFW_KEY_MINUS || key == GLFW_KEY_KP_SUBTRACT) choices_.larger_text(-1);
        if (key == GLFW_KEY_0 || key == GLFW_KEY_KP_0) choices_.text_percent = 100;
        if (key == GLFW_KEY_Q) glfwSetWindowShouldClose(native_.get(), GLFW_TRUE);
    }

    void toggle_part(bool PlayControls::*part) {
        model_.set_control(part, !(model_.controls().*part));
    }

    void mute_all() {
        const std::vector<SourceControl>& sources = model_.controls().sources;
        const bool all = std::all_of(sources.begin(), sources.end(),
                                     [](const SourceControl& s) { return s.muted; });
        for (std::size_t s = 0; s < sources.size(); ++s)
            model_.set_control(s, &SourceControl::muted, !all);
    }

    void handle_key(int key) {
        switch (key) {
            case GLFW_KEY_SLASH:
                choices_.help = !choices_.help;
                break;
            case GLFW_KEY_ESCAPE:
                choices_.help = false;
                model_.deselect();
                break;
            case GLFW_KEY_V:
                picture_.camera.first_person = !picture_.camera.first_person;
                break;
            case GLFW_KEY_T:
                model_.follow_path();
                break;
            case GLFW_KEY_C:
                model_.collides = !model_.collides;
                break;
            case GLFW_KEY_X:
                model_.switch_setting();
                break;
            case GLFW_KEY_F:
                model_.frozen = !model_.frozen;
                break;
            case GLFW_KEY_P:
                choices_.rays = !choices_.rays;
                break;
            case GLFW_KEY_B:
                choices_.direct_paths = !choices_.direct_paths;
                break;
            case GLFW_KEY_E:
                choices_.overlay =
                    static_cast<EnergyOverlay>((static_cast<int>(choices_.overlay) + 1) % 3);
                break;
            case GLFW_KEY_G:
                choices_.style.solid = !choices_.style.solid;
                break;
            case GLFW_KEY_R:
                model_.toggle_recording();
                break;
            case GLFW_KEY_M:
                mute_all();
                break;
            case GLFW_KEY_PAGE_UP:
                model_.open_next(-1);
                break;
            case GLFW_KEY_PAGE_DOWN:
                model_.open_next(1);
                break;
            case GLFW_KEY_1:
                toggle_part(&PlayControls::direct);
                break;
            case GLFW_KEY_2:
                toggle_part(&PlayControls::early);
                break;
            case GLFW_KEY_3:
                toggle_part(&PlayControls::late);
                break;
            default:
                break;
        }
    }

    void handle_keys() {
        for (const auto& event : native_.take_keys()) {
            if (!event.pressed) keys_.release(event.key, event.time_s);
            // A list that has just opened takes letters before its search field is active.
            const bool typed = ImGui::GetIO().WantTextInput || ImGui::IsPopupOpen("", kAnyPopup);
            if (!event.pressed || typed) continue;
            if (event.control) {
                handle_control_key(event.key);
            } else {
                keys_.press(event.key, event.time_s);
                handle_key(event.key);
            }
        }
    }

    template <typename Fill>
    void panel(const char* name, const Box& box, const Fill& fill) {
        ImGui::SetNextWindowPos({box.x, box.y});
        ImGui::SetNextWindowSize({box.width, box.height});
        if (ImGui::Begin(name, nullptr,
                         ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                             ImGuiWindowFlags_NoSavedSettings |
                             ImGuiWindowFlags_NoBringToFrontOnFocus))
            fill();
        ImGui::End();
    }

    /// Handles the next mouse event and lays out the window. Returns the picture's rectangle.
    Box lay_out() {
        gui_.begin_frame(native_.mouse());
        const ImVec2 whole = ImGui::GetIO().DisplaySize;
        const Layout layout = window_layout(whole.x, whole.y, ImGui::GetFontSize(), meters_height_);
        picture_.interact(model_, layout.picture, choices_);

        panel("bar", layout.bar, [&] { draw_top_bar(model_, choices_, picture_.camera); });
        panel("plots", layout.plots, [&] { draw_plots(model_, choices_.plots); });
        panel("controls", layout.controls, [&] {
            ImGui::BeginChild("list");
            draw_controls(model_, choices_);
            ImGui::EndChild();
        });
        panel("meters", layout.meters, [&] {
            // A scroll bar would wrap lines, which changes the height, in turn.
            const bool fits = meters_height_ <= layout.meters.height;
            ImGui::BeginChild("list", {0, 0}, false, fits ? ImGuiWindowFlags_NoScrollbar : 0);
            meters_.draw(model_);
            meters_height_ = ImGui::GetCursorPosY() + 2 * ImGui::GetStyle().WindowPadding.y;
            ImGui::EndChild();
        });
        if (choices_.help) draw_help(choices_);
        picture_.draw_labels(model_, layout.picture, choices_);
        draw_messages(model_, {layout.picture.x + 12, layout.plots.y - 3.5F * ImGui::GetFontSize()},
                      layout.picture.width - 24, glfwGetTime());
        ImGui::Render();
        return layout.picture;
    }

    void draw(double dt_s) {
        glfwGetFramebufferSize(native_.get(), &width_, &height_);
        int width = 0;
        int height = 0;
        glfwGetWindowSize(native_.get(), &width, &height);
        gui_.set_scale(text_scale(static_cast<float>(width), static_cast<float>(height),
                                  gui_.display_scale(), choices_.zoom()));
        handle_keys();
        walk();
        for (const std::string& file : native_.take_dropped()) model_.take_file(file);
        native_.set_title(model_.scene_file().filename().string() + " - Aula");
        // The first layout finds the meters' height. Each mouse event takes one more.
        const float meters_height = meters_height_;
        Box area = lay_out();
        if (meters_height_ != meters_height) area = lay_out();
        while (native_.mouse().pending()) area = lay_out();

        if (width_ == 0 || height_ == 0) return;  // iconified
        const float scale =
            static_cast<float>(width_) / std::max(1.0F, ImGui::GetIO().DisplaySize.x);
        if (native_.software() && !options_.screenshot) glDisable(GL_MULTISAMPLE);
        glViewport(0, 0, width_, height_);
        glClearColor(0, 0, 0, 1);
        glClear(GL_COLOR_BUFFER_BIT);
        picture_.draw(model_, area, choices_, scale, height_, dt_s);
        glViewport(0, 0, width_, height_);
        ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    }

    const WindowOptions& options_;
    Model& model_;
    Choices choices_;
    NativeWindow native_;
    Gui gui_;
    Picture picture_;
    Meters meters_;
    float meters_height_ = 0;  ///< of the last layout
    std::optional<OutputFile> screenshot_;
    HeldKeys keys_;
    int width_ = 0;
    int height_ = 0;
};

}  // namespace

bool window_possible() { return opens_window(); }

PlayStatus show_window(const WindowOptions& options) {
    // The player's threads run already and keep their priority; drawing runs at a lower one.
    Model model(options);
    lower_priority(kPropagationNice + 5);
    const Glfw glfw;
    if (!glfw.started())
        throw Failure("no display is available; --no-window plays in the terminal");
    const auto file = options.keeps_state ? state_file() : std::nullopt;
    App app(options, model, file ? read_state(*file) : WindowState{});
    app.run();
    // Before the model's destructor waits for background jobs.
    model.player().stop_recording();
    if (file) write_state(app.state(), *file);
    return model.status();
}

}  // namespace aula
