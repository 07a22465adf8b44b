// write_sound clap|vst3 FILE: a second of noise in a room that ships, as a plugin renders it, as
// floats: the left ear, then the right ear. For .ci/windows.

#include <cstdio>
#include <exception>
#include <fstream>
#include <string>

#include "tests/plugin/clap_host.h"
#include "tests/plugin/vst3/vst3_host.h"

namespace {

using namespace aula::test;
using aula::plugin::Control;

constexpr double kRoom = 2;  // of the control `room`, 0 to 8
const std::string kPlugin = aula::plugin::kKinds[0].id;

Channels clap_sound(const Channels& input) {
    ClapHost host(kPlugin);
    host.set_offline(true);
    demand(host.activate(), "not active");
    return host.run(input, {512}, {{0, Control::room, kRoom}});
}

Channels vst3_sound(const Channels& input) {
    const Vst3Host host(kPlugin);
    demand(host.set_up(true) == V3_OK && host.set_active(true) == V3_OK, "not active");
    return host.run(input, 512, {{0, Control::room, kRoom / 8}});
}

}  // namespace

int main(int count, char** arguments) {
    try {
        demand(count == 3, "expected clap|vst3 FILE");
        const Channels input{noise(48000)};
        const bool is_clap = std::string(arguments[1]) == "clap";
        std::ofstream file(arguments[2], std::ios::binary);
        for (const std::vector<float>& channel : is_clap ? clap_sound(input) : vst3_sound(input))
            file.write(reinterpret_cast<const char*>(channel.data()),
                       static_cast<std::streamsize>(channel.size() * sizeof(float)));
        return file.flush() ? 0 : 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "write_sound: %s\n", error.what());
        return 1;
    }
}
