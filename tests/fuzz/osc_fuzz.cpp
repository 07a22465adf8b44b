#include <cmath>
#include <span>

#include "apps/session/remote/osc.h"
#include "tests/fuzz/fuzz_target.h"

using namespace aula;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static OscInput input("0", [](const OscMessage& message) {
        test::expect(message.address.starts_with('/'), "an address begins with a slash");
        for (std::size_t i = 0; i <= message.arguments.size(); ++i) {
            const auto number = message.number(i);
            test::expect(!number || std::isfinite(*number), "a number is finite");
            test::expect(!number || message.text(i) == nullptr, "a number is no text");
        }
    });
    input.read(std::as_bytes(std::span(data, size)));
    return 0;
}
