#include "apps/aula/commands.h"
#include "apps/room/remote/osc.h"
#include "aula/exception.h"

namespace aula {

namespace {

[[noreturn]] void refuse(const std::string& what) {
    throw InputError(what +
                     ": Aula has no audio devices on Windows; expected --offline OUT.wav, --ir or "
                     "a command");
}

}  // namespace

int list_devices() { refuse("--list-devices"); }
int play(const Arguments& arguments) { refuse(arguments.scene.string()); }
void check_osc_address(const std::string&) { refuse("--osc"); }

}  // namespace aula
