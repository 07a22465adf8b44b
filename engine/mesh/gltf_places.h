#pragma once

#include <glm/mat4x4.hpp>
#include <string>
#include <vector>

#include "engine/input/json_reader.h"
#include "engine/mesh/mesh_import.h"

namespace aula {

/// The sources and the listener of a glTF file: nodes with an emitter of KHR_audio_emitter; nodes
/// without a mesh whose names begin with "source" or "speaker", or with "listener", or mean one
/// (guess_place()); and nodes with a camera, which are listeners.
class GltfPlaces {
 public:
    explicit GltfPlaces(const JsonReader& root);

    /// Adds what a node stands for, if anything. `transform` is that of the node.
    void add(const JsonReader& node, const glm::dmat4& transform);

    /// Listeners by name precede cameras.
    std::vector<ImportedPlace> take();

    /// Names of nodes that have a mesh, and are thus no sources, and the name of a source.
    const std::vector<std::string>& shapes_of_sources() const { return shapes_of_sources_; }

 private:
    bool add_emitter(const JsonReader& node, ImportedPlace place);
    void read_sound(const JsonReader& source, ImportedPlace& place) const;

    std::vector<JsonReader> emitters_, sources_, sounds_;
    std::vector<ImportedPlace> places_, cameras_;
    std::vector<std::string> shapes_of_sources_;
};

}  // namespace aula
