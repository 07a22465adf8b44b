#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "apps/aula/arguments/arguments.h"
#include "apps/aula/commands.h"
#include "apps/aula/scene_lookup.h"
#include "apps/aula/terminal/interrupt.h"
#include "apps/aula/terminal/standard_output.h"
#include "apps/aula/terminal/terminal.h"
#include "apps/output/printable.h"
#include "aula/devices/device.h"
#include "aula/engine/scene_file.h"
#include "aula/exception.h"
#include "engine/rays/ray_scene.h"

namespace aula {

namespace {

/// The exit status of an interrupt if a signal has arrived, else `status`.
int unless_interrupted(int status) {
    return interrupt_signal() != 0 ? interrupted_status() : status;
}

/// Prints a message to standard error as one line; returns `status`.
int fail(const std::string& message, int status) {
    std::fprintf(stderr, "aula: %s\n", printable_line(message).c_str());
    return status;
}

/// Checks a scene; prints all its errors, one per line.
int check(const Arguments& arguments) {
    try {
        return unless_interrupted(check_scene(arguments));
    } catch (const SceneErrors& errors) {
        for (const std::string& message : errors.messages()) fail(message, 2);
        return 2;
    }
}

/// The command line, with the file of its scene.
Arguments with_scene_file(Arguments arguments) {
    if (!arguments.scene.empty()) arguments.scene = find_scene(arguments.scene, scene_folders());
    return arguments;
}

int run(const Arguments& arguments) {
    using Command = Arguments::Command;
    switch (arguments.command) {
        case Command::help:
            std::fputs(help_text(arguments.help).c_str(), stdout);
            return 0;
        case Command::version:
            std::printf("aula %s with %s\n", AULA_VERSION, ray_library().c_str());
            return 0;
        case Command::list_devices:
            return list_devices();
        case Command::materials:
            return unless_interrupted(list_materials(arguments));
        case Command::info:
            return unless_interrupted(show_info(arguments));
        case Command::check:
            return check(arguments);
        case Command::import:
            return unless_interrupted(import_model(arguments));
        case Command::play:
            return play(arguments);
        case Command::render:
            return render(arguments);
        case Command::measure:
            return measure(arguments);
        case Command::dataset:
            return dataset(arguments.dataset);
        case Command::map:
            return map_room(arguments);
        case Command::report:
            return report_room(arguments);
        case Command::analyse:
            return analyse(arguments);
    }
    return 1;
}

/// The message for a resource that the system refused.
std::string refusal(const std::error_code& code) {
    if (code == std::errc::resource_unavailable_try_again)
        return "the system allows no more threads; --threads N starts fewer";
    return "the system refused: " + code.message();
}

}  // namespace

}  // namespace aula

int main(int argc, char** argv) {
    try {
        aula::set_up_process();
        const std::vector<std::string> line = aula::command_line(argc, argv);
        std::vector<const char*> words;
        for (const std::string& word : line) words.push_back(word.c_str());
        const int status = aula::run(aula::with_scene_file(
            aula::read_arguments(static_cast<int>(words.size()), words.data())));
        // Buffered output may fail only when it is flushed, as on a full disk.
        aula::flush_standard_output();
        return status;
    } catch (const aula::ReaderEnded&) {
        return aula::kReaderEndedStatus;
    } catch (const aula::InputError& error) {
        return aula::fail(error.what(), 2);
    } catch (const aula::NoAudioDevice& error) {
        return aula::fail(std::string(error.what()) +
                              "; play in silence with --device none, or render to a file with "
                              "--offline OUT.wav",
                          1);
    } catch (const std::bad_alloc&) {
        return aula::fail("out of memory", 1);
    } catch (const std::system_error& error) {
        return aula::fail(aula::refusal(error.code()), 1);
    } catch (const std::exception& error) {
        return aula::fail(error.what(), 1);
    }
}
