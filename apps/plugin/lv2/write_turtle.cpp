// aula_write_turtle FOLDER VERSION_MINOR VERSION_MICRO HAS_EDITOR: writes the Turtle files of the
// bundle: manifest.ttl, aula.ttl and presets.ttl. HAS_EDITOR: 1 or 0.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "apps/plugin/lv2/ports.h"
#include "apps/plugin/presets.h"

namespace {

using namespace aula::plugin;
namespace fs = std::filesystem;

constexpr const char* kPrefixes = R"(@prefix atom: <http://lv2plug.in/ns/ext/atom#> .
@prefix doap: <http://usefulinc.com/ns/doap#> .
@prefix lv2: <http://lv2plug.in/ns/lv2core#> .
@prefix patch: <http://lv2plug.in/ns/ext/patch#> .
@prefix pg: <http://lv2plug.in/ns/ext/port-groups#> .
@prefix pset: <http://lv2plug.in/ns/ext/presets#> .
@prefix rdf: <http://www.w3.org/1999/02/22-rdf-syntax-ns#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix rsz: <http://lv2plug.in/ns/ext/resize-port#> .
@prefix state: <http://lv2plug.in/ns/ext/state#> .
@prefix time: <http://lv2plug.in/ns/ext/time#> .
@prefix ui: <http://lv2plug.in/ns/extensions/ui#> .
@prefix units: <http://lv2plug.in/ns/extensions/units#> .
@prefix urid: <http://lv2plug.in/ns/ext/urid#> .

)";

const char* uri_of(const Kind& layout) {
    return kPluginUris[static_cast<std::size_t>(&layout - kLayouts.data())];
}

std::string number(float value) {
    std::ostringstream text;
    text.precision(7);  // the shortest text of the places, which have few decimals
    text << value;
    const bool whole = text.str().find('.') == std::string::npos;
    return text.str() + (whole ? ".0" : "");
}

/// The URI of a group of ports of a layout.
std::string group_uri(const Kind& layout, const std::string& group) {
    return "<" + std::string(uri_of(layout)) + "-" + group + ">";
}

std::string group_class(aula::OutputFormat output) {
    switch (output) {
        case aula::OutputFormat::foa:
            return "pg:AmbisonicBH1P1Group";
        case aula::OutputFormat::toa:
            return "pg:AmbisonicBH3P3Group";
        default:
            return "pg:StereoGroup";
    }
}

std::string output_designation(aula::OutputFormat output, std::size_t channel) {
    if (output == aula::OutputFormat::binaural) return channel == 0 ? "pg:left" : "pg:right";
    return "pg:ACN" + std::to_string(channel);
}

std::string audio_ports(const Kind& layout) {
    std::ostringstream text;
    text << "[\n\t\ta lv2:InputPort , lv2:AudioPort ;\n\t\tlv2:index 0 ;\n\t\tlv2:symbol \"in\" ;\n"
         << "\t\tlv2:name \"Input\"\n\t]";
    const std::size_t channels = channel_count(layout.output);
    for (std::size_t c = 0; c < channels; ++c) {
        text << " , [\n\t\ta lv2:OutputPort , lv2:AudioPort ;\n\t\tlv2:index " << 1 + c
             << " ;\n\t\tlv2:symbol \"out_" << 1 + c << "\" ;\n\t\tlv2:name \"Output " << 1 + c
             << "\" ;\n\t\tpg:group " << group_uri(layout, "output") << " ;\n\t\tlv2:designation "
             << output_designation(layout.output, c) << "\n\t]";
    }
    return text.str();
}

/// The term of the vocabulary of units.
std::string unit_of(const ControlInfo& info) {
    std::string unit = info.unit;
    if (unit == "°") return "degree";
    if (unit == "dB") return "db";
    // A share.
    if (unit.empty() && info.kind == ControlInfo::Kind::number) return "coef";
    return unit;
}

std::string controls_text(const Kind& layout, std::size_t first, std::size_t last) {
    std::ostringstream text;
    for (std::size_t i = first; i < last; ++i) {
        const ControlInfo& info = control_infos()[i];
        using Kind = ControlInfo::Kind;
        text << " , [\n\t\ta lv2:InputPort , lv2:ControlPort ;\n\t\tlv2:index "
             << control_port(layout.output, i) << " ;\n\t\tlv2:symbol \"" << info.symbol
             << "\" ;\n\t\tlv2:name \"" << info.name << "\" ;\n\t\tlv2:default "
             << number(info.initial) << " ;\n\t\tlv2:minimum " << number(info.least)
             << " ;\n\t\tlv2:maximum " << number(info.greatest);
        if (info.kind == Kind::toggle) text << " ;\n\t\tlv2:portProperty lv2:toggled";
        if (info.kind == Kind::integer) text << " ;\n\t\tlv2:portProperty lv2:integer";
        if (info.kind == Kind::enumeration)
            text << " ;\n\t\tlv2:portProperty lv2:integer , lv2:enumeration";
        for (std::size_t s = 0; s < info.scale_points.size(); ++s)
            text << " ;\n\t\tlv2:scalePoint [ rdfs:label \"" << info.scale_points[s]
                 << "\" ; rdf:value " << number(info.least + static_cast<float>(s)) << " ]";
        if (const std::string unit = unit_of(info); !unit.empty())
            text << " ;\n\t\tunits:unit units:" << unit;
        if (*info.group != 0) text << " ;\n\t\tpg:group " << group_uri(layout, info.group);
        if (static_cast<Control>(i) == Control::enabled)
            text << " ;\n\t\tlv2:designation lv2:enabled";
        if (*info.comment != 0) text << " ;\n\t\trdfs:comment \"" << info.comment << "\"";
        text << "\n\t]";
    }
    return text.str();
}

/// What no other format has as a control.
std::string host_ports(const Kind& layout) {
    std::ostringstream text;
    text << " , [\n\t\ta lv2:InputPort , lv2:ControlPort ;\n\t\tlv2:index "
         << freewheel_port(layout.output)
         << " ;\n\t\tlv2:symbol \"freewheel\" ;\n\t\tlv2:name \"Freewheel\" ;\n"
         << "\t\tlv2:default 0.0 ;\n\t\tlv2:minimum 0.0 ;\n\t\tlv2:maximum 1.0 ;\n"
         << "\t\tlv2:portProperty lv2:toggled ;\n\t\tlv2:designation lv2:freeWheeling ;\n"
         << "\t\trdfs:comment \"Renders on the exact clock; processing may take longer than real "
            "time.\"\n\t] , [\n"
         << "\t\ta lv2:OutputPort , lv2:ControlPort ;\n\t\tlv2:index "
         << latency_port(layout.output)
         << " ;\n\t\tlv2:symbol \"latency\" ;\n\t\tlv2:name \"Latency\" ;\n"
         << "\t\tlv2:default 0.0 ;\n\t\tlv2:minimum 0.0 ;\n\t\tlv2:maximum 8192.0 ;\n"
         << "\t\tlv2:portProperty lv2:integer ;\n\t\tunits:unit units:frame ;\n"
         << "\t\tlv2:designation lv2:latency ;\n\t\tlv2:portProperty lv2:reportsLatency\n\t]";
    return text.str();
}

std::string event_ports(const Kind& layout) {
    const std::uint32_t first = messages_port(layout.output);
    std::ostringstream text;
    text << " , [\n\t\ta lv2:InputPort , atom:AtomPort ;\n\t\tlv2:index " << first
         << " ;\n\t\tlv2:symbol \"control\" ;\n\t\tlv2:name \"Control\" ;\n"
         << "\t\tatom:bufferType atom:Sequence ;\n"
         << "\t\tatom:supports patch:Message , time:Position ;\n"
         << "\t\tlv2:designation lv2:control ;\n"
         << "\t\tlv2:portProperty lv2:connectionOptional\n\t] , [\n"
         << "\t\ta lv2:OutputPort , atom:AtomPort ;\n\t\tlv2:index " << first + 1
         << " ;\n\t\tlv2:symbol \"notify\" ;\n\t\tlv2:name \"Notify\" ;\n"
         << "\t\tatom:bufferType atom:Sequence ;\n\t\tatom:supports patch:Message ;\n"
         << "\t\tlv2:designation lv2:control ;\n"
         << "\t\trsz:minimumSize 16384 ;\n"
         << "\t\tlv2:portProperty lv2:connectionOptional\n\t]";
    return text.str();
}

std::string level_text(const Kind& layout) {
    std::ostringstream text;
    text << " , [\n\t\ta lv2:OutputPort , lv2:ControlPort ;\n\t\tlv2:index "
         << level_port(layout.output)
         << " ;\n\t\tlv2:symbol \"level\" ;\n\t\tlv2:name \"Output Level\" ;\n"
         << "\t\tlv2:default -120.0 ;\n\t\tlv2:minimum -120.0 ;\n\t\tlv2:maximum 24.0 ;\n"
         << "\t\tunits:unit units:db ;\n"
         << "\t\trdfs:comment \"Peak of the outputs re full scale; it falls slowly.\"\n\t]";
    return text.str();
}

/// What an editor needs, and the port of its messages for each layout.
std::string editor_text() {
    std::ostringstream text;
    text << "<" << kEditorUri << ">\n\ta ui:X11UI ;\n"
         << "\tlv2:requiredFeature ui:idleInterface , ui:parent , urid:map ;\n"
         << "\tlv2:optionalFeature ui:resize , ui:touch ;\n"
         << "\tlv2:extensionData ui:idleInterface";
    for (const Kind& layout : kLayouts)
        text << " ;\n\tui:portNotification [\n\t\tui:plugin <" << uri_of(layout)
             << "> ;\n\t\tlv2:symbol \"notify\" ;\n\t\tui:notifyType atom:Object\n\t]";
    text << " .\n\n";
    return text.str();
}

std::string plugin_text(const Kind& layout, const std::string& version) {
    std::ostringstream text;
    text << group_uri(layout, "output") << "\n\ta pg:OutputGroup , " << group_class(layout.output)
         << " ;\n\tlv2:symbol \"output\" ;\n\tlv2:name \"Output\" .\n\n";
    for (const auto& [symbol, name] :
         {std::pair{"source", "Source"}, std::pair{"listener", "Listener"},
          std::pair{"sound", "Sound"}})
        text << group_uri(layout, symbol) << "\n\ta pg:InputGroup ;\n\tlv2:symbol \"" << symbol
             << "\" ;\n\tlv2:name \"" << name << "\" .\n\n";
    text << "<" << uri_of(layout) << ">\n\ta lv2:Plugin , lv2:ReverbPlugin ;\n\tdoap:name \""
         << layout.name << "\" ;\n\tdoap:license <https://spdx.org/licenses/Apache-2.0> ;\n"
         << version
         << "\trdfs:comment \"The sound of a source at a place in a room: direct sound, "
            "reflections and reverberation of the geometry and materials of a scene.\" ;\n"
         << "\tlv2:optionalFeature lv2:hardRTCapable , urid:map , state:mapPath , "
            "state:freePath , state:threadSafeRestore ;\n"
         << "\tlv2:extensionData state:interface ;\n"
         << "\tpatch:writable <" AULA_PLUGIN_URI "#scene> , <" AULA_PLUGIN_URI "#hrtf> ;\n"
         << "\tpatch:readable <" AULA_PLUGIN_URI "#status> ;\n"
         << "\tlv2:port " << audio_ports(layout) << controls_text(layout, 0, kFirstControls)
         << host_ports(layout) << event_ports(layout)
         << controls_text(layout, kFirstControls, kControls) << level_text(layout) << " .\n\n";
    return text.str();
}

std::string plugins_file(const std::string& version, bool has_editor) {
    std::string text = kPrefixes;
    text += "<" AULA_PLUGIN_URI
            "#scene>\n\ta lv2:Parameter ;\n\trdfs:label \"Scene\" ;\n"
            "\trdfs:comment \"Scene file; empty: the default room.\" ;\n"
            "\trdfs:range atom:Path .\n\n"
            "<" AULA_PLUGIN_URI
            "#hrtf>\n\ta lv2:Parameter ;\n\trdfs:label \"HRTF\" ;\n"
            "\trdfs:comment \"SOFA file of head-related impulse responses; empty: MIT KEMAR.\" ;\n"
            "\trdfs:range atom:Path .\n\n"
            "<" AULA_PLUGIN_URI
            "#status>\n\ta lv2:Parameter ;\n\trdfs:label \"Status\" ;\n"
            "\trdfs:comment \"The error of the last scene or HRTF; empty: none.\" ;\n"
            "\trdfs:range atom:String .\n\n";
    for (const Kind& layout : kLayouts) text += plugin_text(layout, version);
    if (has_editor) text += editor_text();
    return text;
}

std::string preset_uri(const Preset& preset) {
    return std::string("<" AULA_PLUGIN_URI "#preset-") + preset.id + ">";
}

std::string manifest_file(const std::string& version, bool has_editor) {
    std::ostringstream text;
    text << kPrefixes;
    for (const Kind& layout : kLayouts)
        text << "<" << uri_of(layout) << ">\n\ta lv2:Plugin ;\n"
             << version << (has_editor ? "\tui:ui <" + std::string(kEditorUri) + "> ;\n" : "")
             << "\tlv2:binary <aula.so> ;\n\trdfs:seeAlso <aula.ttl> .\n\n";
    if (has_editor)
        text << "<" << kEditorUri << ">\n\ta ui:X11UI ;\n\tui:binary <aula_editor.so> ;\n"
             << "\trdfs:seeAlso <aula.ttl> .\n\n";
    for (const Preset& preset : presets()) {
        text << preset_uri(preset) << "\n\ta pset:Preset ;\n\tlv2:appliesTo";
        for (const Kind& layout : kLayouts)
            text << (&layout == kLayouts.data() ? " <" : " , <") << uri_of(layout) << ">";
        text << " ;\n\trdfs:label \"" << preset.name << "\" ;\n\trdfs:seeAlso <presets.ttl> .\n\n";
    }
    return text.str();
}

std::string presets_file() {
    std::ostringstream text;
    text << kPrefixes;
    for (const Preset& preset : presets()) {
        ControlValues values;
        for (std::size_t i = 0; i < kControls; ++i) values[i] = control_infos()[i].initial;
        const auto set = [&](Control first, const aula::Vec3& place) {
            for (int axis = 0; axis < 3; ++axis)
                values[static_cast<std::size_t>(first) + static_cast<std::size_t>(axis)] =
                    place[axis];
        };
        if (preset.source) set(Control::source_x, *preset.source);
        if (preset.listener) {
            set(Control::listener_x, *preset.listener);
            values[static_cast<std::size_t>(Control::listener_yaw)] = preset.listener_yaw_deg;
        }
        text << preset_uri(preset) << "\n\ta pset:Preset ;\n\tlv2:appliesTo";
        for (const Kind& layout : kLayouts)
            text << (&layout == kLayouts.data() ? " <" : " , <") << uri_of(layout) << ">";
        text << " ;\n\trdfs:label \"" << preset.name << "\"";
        if (*preset.scene != 0)
            text << " ;\n\tstate:state [ <" AULA_PLUGIN_URI "#scene> <" << preset.scene << "> ]";
        text << " ;\n\tlv2:port";
        // The places, and that the scene of the state is heard; all other controls stay.
        const auto belongs = [](Control control) {
            return control <= Control::listener_roll || control >= Control::room;
        };
        for (std::size_t i = 0; i < kControls; ++i) {
            if (!belongs(static_cast<Control>(i))) continue;
            text << (i == 0 ? " [" : " , [") << "\n\t\tlv2:symbol \"" << control_infos()[i].symbol
                 << "\" ;\n\t\tpset:value " << number(values[i]) << "\n\t]";
        }
        text << " .\n\n";
    }
    return text.str();
}

void write(const fs::path& file, const std::string& text) {
    std::ofstream out(file);
    out << text;
    if (!out.flush()) throw std::runtime_error(file.string() + ": cannot be written");
}

}  // namespace

int main(int argc, char** argv) {
    try {
        if (argc != 5)
            throw std::runtime_error("usage: aula_write_turtle FOLDER MINOR MICRO HAS_EDITOR");
        const fs::path folder = argv[1];
        const std::string version = std::string("\tlv2:minorVersion ") + argv[2] +
                                    " ;\n\tlv2:microVersion " + argv[3] + " ;\n";
        const bool has_editor = std::string(argv[4]) == "1";
        write(folder / "manifest.ttl", manifest_file(version, has_editor));
        write(folder / "aula.ttl", plugins_file(version, has_editor));
        write(folder / "presets.ttl", presets_file());
    } catch (const std::exception& error) {
        std::cerr << "aula_write_turtle: " << error.what() << '\n';
        return 1;
    }
}
