// Writes the impulse response of the first source of a scene, of one frame: ambisonic channels of
// 32-bit floats, one after another. For .ci/arm64. write_response SCENE FILE
#include <fstream>

#include "aula/engine/impulse_response.h"
#include "aula/engine/propagation.h"
#include "aula/engine/scene_file.h"

int main(int, char** argv) {
    const aula::Scene scene = aula::load_scene(argv[1]).scene;
    aula::Propagation propagation(scene, scene.simulation);
    propagation.step(
        {.sources = {scene.sources[0].position}, .listeners = {scene.listener.pose.position}});
    aula::ImpulseResponseBuilder builder(aula::make_noise_carriers(48000, 1), scene.medium,
                                         propagation.response_length_s(), "source");
    aula::ImpulseResponse response;
    builder.build(propagation.response(0), response);
    std::ofstream out(argv[2], std::ios::binary);
    for (const auto& channel : response.channels) {
        out.write(reinterpret_cast<const char*>(channel.data()),
                  static_cast<std::streamsize>(channel.size() * sizeof(float)));
    }
}
