// Renders a sound in the room of a scene file: render_file SCENE IN.wav OUT.wav
#include <aula/audio/sound_file.h>
#include <aula/auralizer.h>
#include <aula/engine/scene_file.h>

#include <cstdio>
#include <exception>
#include <vector>

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: render_file SCENE IN.wav OUT.wav\n");
        return 2;
    }
    try {
        const aula::LoadedScene loaded = aula::load_scene(argv[1]);
        aula::AuralizerOptions options;
        options.clock = aula::RenderClock::exact;  // waits for the propagation; repeatable
        options.before_frame = aula::follow_paths(loaded.scene);
        aula::Auralizer auralizer(loaded.scene, options);
        if (auralizer.sources().empty()) auralizer.add_source({.position = {1, 1, 1.5F}});

        const std::vector<float> sound =
            aula::read_sound(argv[2], auralizer.sample_rate_hz()).samples;
        const auto length = static_cast<std::int64_t>(sound.size());
        const std::size_t channels = auralizer.output_channels();
        aula::WavWriter out(argv[3], auralizer.sample_rate_hz(), channels,
                            aula::SampleFormat::float32);

        constexpr int kBlock = 512;
        std::vector<float> input(kBlock);
        std::vector<std::vector<float>> output(channels, std::vector<float>(kBlock));
        std::vector<float> interleaved(kBlock * channels);
        std::vector<float*> pointers;
        for (std::vector<float>& channel : output) pointers.push_back(channel.data());
        auralizer.commit(length + auralizer.tail_samples());  // only the scene's paths change it
        for (std::int64_t at = 0; at < length + auralizer.tail_samples(); at += kBlock) {
            for (std::int64_t n = 0; n < kBlock; ++n) {
                const auto k = static_cast<std::size_t>(at + n);
                input[static_cast<std::size_t>(n)] = k < sound.size() ? sound[k] : 0;
            }
            const aula::SourceSignal signal{auralizer.sources()[0], input.data()};
            auralizer.render({&signal, 1}, pointers, kBlock);
            for (std::size_t n = 0; n < kBlock; ++n)
                for (std::size_t c = 0; c < channels; ++c)
                    interleaved[n * channels + c] = output[c][n];
            out.write(interleaved);
        }
        out.commit();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "render_file: %s\n", error.what());
        return 2;
    }
}
