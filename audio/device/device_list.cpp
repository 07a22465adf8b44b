#include "audio/device/device_list.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "aula/exception.h"

namespace aula {

namespace {

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

std::string listed(const std::vector<DeviceInfo>& devices) {
    std::string text;
    for (const DeviceInfo& device : devices) {
        if (!text.empty()) text += ", ";
        text += std::to_string(device.index) + " \"" + device.name + "\" (" + device.host_api + ")";
    }
    return text;
}

}  // namespace

std::string client_of(const std::string& jack_port) {
    return jack_port.substr(0, jack_port.find(':'));
}

std::vector<DeviceInfo> group_by_client(const std::vector<DeviceInfo>& jack_ports) {
    std::vector<DeviceInfo> devices;
    for (DeviceInfo port : jack_ports) {
        port.name = client_of(port.name);
        const auto found = std::find_if(devices.begin(), devices.end(),
                                        [&](const DeviceInfo& d) { return d.name == port.name; });
        if (found != devices.end())
            ++found->output_channels;
        else
            devices.push_back(std::move(port));
    }
    return devices;
}

std::vector<DeviceInfo> merge_outputs(std::vector<DeviceInfo> jack,
                                      const std::vector<DeviceInfo>& others) {
    std::vector<DeviceInfo> devices = std::move(jack);
    devices.insert(devices.end(), others.begin(), others.end());
    int index = 0;
    bool found = false;
    for (DeviceInfo& device : devices) {
        device.index = index++;
        device.is_default = device.is_default && !std::exchange(found, found || device.is_default);
    }
    return devices;
}

DeviceInfo choose_output(const std::vector<DeviceInfo>& devices, const std::string& wanted) {
    if (devices.empty()) throw NoAudioDevice();
    if (wanted.empty()) {
        const auto found = std::find_if(devices.begin(), devices.end(),
                                        [](const DeviceInfo& d) { return d.is_default; });
        return found == devices.end() ? devices.front() : *found;
    }
    std::vector<DeviceInfo> matches;
    for (const DeviceInfo& device : devices) {
        if (wanted == std::to_string(device.index)) return device;
    }
    // A complete name takes precedence over parts of names.
    for (const bool whole : {true, false}) {
        for (const DeviceInfo& device : devices) {
            const std::string name = lower(device.name);
            const bool match =
                whole ? name == lower(wanted) : name.find(lower(wanted)) != std::string::npos;
            if (match) matches.push_back(device);
        }
        if (!matches.empty()) break;
    }
    if (matches.empty()) {
        throw InputError("audio device \"" + wanted +
                         "\": no such output; expected the index or a part of the name of " +
                         listed(devices));
    }
    if (matches.size() > 1) {
        throw InputError("audio device \"" + wanted +
                         "\": matches several outputs; expected one of " + listed(matches));
    }
    return matches.front();
}

}  // namespace aula
