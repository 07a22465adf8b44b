#pragma once

#include <string>
#include <vector>

#include "aula/devices/device.h"

namespace aula {

/// The client of a JACK port "client:port".
std::string client_of(const std::string& jack_port);

/// The devices of JACK's input ports, which are given as devices of one channel: one device for
/// each client, with the properties of its first port.
std::vector<DeviceInfo> group_by_client(const std::vector<DeviceInfo>& jack_ports);

/// JACK's devices, then the others, with their indices. The first default is the only one.
std::vector<DeviceInfo> merge_outputs(std::vector<DeviceInfo> jack,
                                      const std::vector<DeviceInfo>& others);

/// The device of an index, a name or a part of one (case is ignored); the default device if
/// `wanted` is empty. Throws InputError if `wanted` matches no or several devices, and
/// NoAudioDevice if there is none.
DeviceInfo choose_output(const std::vector<DeviceInfo>& devices, const std::string& wanted);

}  // namespace aula
