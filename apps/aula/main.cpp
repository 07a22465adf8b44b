#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>

#include "apps/aula/arguments.h"
#include "apps/aula/commands.h"
#include "apps/aula/interrupt.h"
#include "audio/error.h"
#include "engine/error.h"

namespace aula {

namespace {

int run(const Arguments& arguments) {
    using Command = Arguments::Command;
    switch (arguments.command) {
        case Command::help:
            std::fputs(help_text(), stdout);
            return 0;
        case Command::version:
            std::puts("aula " AULA_VERSION);
            return 0;
        case Command::list_devices:
            return list_devices();
        case Command::materials:
            return list_materials(arguments);
        case Command::info:
            return show_info(arguments);
        case Command::check:
            return check_scene(arguments);
        case Command::play:
            return play(arguments);
        case Command::render:
            return render(arguments);
        case Command::measure:
            return measure(arguments);
    }
    return 1;
}

/// One line on standard error, whatever the message holds.
int fail(std::string message, int status) {
    std::replace(message.begin(), message.end(), '\n', ' ');
    std::fprintf(stderr, "aula: %s\n", message.c_str());
    return status;
}

}  // namespace

}  // namespace aula

int main(int argc, char** argv) {
    try {
        aula::note_interrupts();
        return aula::run(aula::read_arguments(argc, argv));
    } catch (const aula::Error& error) {
        return aula::fail(error.what(), 2);
    } catch (const aula::AudioInputError& error) {
        return aula::fail(error.what(), 2);
    } catch (const std::exception& error) {
        return aula::fail(error.what(), 1);
    }
}
