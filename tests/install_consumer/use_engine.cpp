// Propagates a frame and synthesises its impulse response: use_engine SCENE
#include <aula/engine/impulse_response.h>
#include <aula/engine/propagation.h>
#include <aula/engine/room_acoustics.h>
#include <aula/engine/scene_file.h>

#include <cstdio>

int main(int, char** argv) {
    const aula::Scene scene = aula::load_scene(argv[1]).scene;
    aula::Propagation propagation(scene, scene.simulation);
    propagation.step(
        {.sources = {scene.sources[0].position}, .listeners = {scene.listener.pose.position}});
    const aula::RoomParameters parameters = aula::room_parameters(propagation.response(0));
    aula::ImpulseResponseBuilder builder(aula::make_noise_carriers(48000, 1), scene.medium,
                                         propagation.response_length_s(), "source");
    aula::ImpulseResponse response;
    builder.build(propagation.response(0), response);
    std::printf("G %.1f dB at 1 kHz, %zu samples\n", parameters[4].g_db.value_or(-999),
                response.channels[0].size());
}
