#include <cstdio>
#include <cstring>
#include <span>
#include <string>

#include "audio/file/sound_answer.h"
#include "audio/file/sound_decoder.h"
#include "tests/fuzz/fuzz_target.h"

using namespace aula;

/// The program that decodes sounds in a child process runs in this one, so that libFuzzer sees it.
/// Its answer must be a header, and the blocks of a usable sound.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    // Output to standard output goes to this file.
    [[maybe_unused]] static const auto* const printed =
        std::freopen((test::fuzz_folder().path() / "stdout").c_str(), "w", stdout);
    std::string answer;
    constexpr std::size_t kLongest = std::size_t{1} << 24;  // 64 MiB take a fraction of a second
    decode_sound(std::as_bytes(std::span(data, size)), [&](const void* bytes, std::size_t count) {
        answer.append(static_cast<const char*>(bytes), count);
        return answer.size() < kLongest;
    });
    test::expect(std::ftell(stdout) == 0, "nothing is printed");
    SoundHeader header;
    test::expect(answer.size() >= sizeof(header), "an answer has a header");
    std::memcpy(&header, answer.data(), sizeof(header));
    test::expect(header.magic == SoundHeader::kMagic, "the header is one of a sound");
    std::size_t at = sizeof(header);
    SoundBlock block{.samples = 1};
    while (header.verdict == SoundHeader::Verdict::usable && block.samples > 0 &&
           answer.size() < kLongest) {
        test::expect(answer.size() - at >= sizeof(block), "the last block is empty");
        std::memcpy(&block, &answer[at], sizeof(block));
        at += sizeof(block);
        test::expect(block.samples <= SoundBlock::kMaxSamples &&
                         answer.size() - at >= block.samples * sizeof(float),
                     "a block has the samples that it says");
        at += block.samples * sizeof(float);
    }
    test::expect(at == answer.size() || answer.size() >= kLongest, "nothing follows");
    return 0;
}
