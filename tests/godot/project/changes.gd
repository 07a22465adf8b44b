extends Node
## Rooms without walls: more sources than a room has places for, a source and listeners that are not
## below a room, and rooms that come and go. A room with walls that a rebuild takes away.

const FAR := Vector3(0, 0, -900)
const NEAR := Vector3(0, 0, -1)

## After it the bus is without a source that stops, also on a loaded machine.
const MIX_S := 0.2

var capture := AudioEffectCapture.new()
var failed := false


func expect(holds: bool, text: String) -> void:
	if not holds:
		failed = true
		print("failed: ", text)


## Waits until something is heard for 0.3 s, or nothing is; at most 20 s.
func wait_for_sound(is_loud: bool, text: String) -> void:
	var start := Time.get_ticks_msec()
	var times := 0
	while times < 3 and Time.get_ticks_msec() < start + 20000:
		await get_tree().create_timer(0.1).timeout
		var is_heard := AudioServer.get_bus_peak_volume_left_db(0, 0) > -40
		times = times + 1 if is_heard == is_loud else 0
	expect(times == 3, text)


## 500 Hz without a pause.
func tone() -> AudioStreamWAV:
	var stream := AudioStreamWAV.new()
	var samples := PackedByteArray()
	for i in 96:
		samples.append(64 if i < 48 else 192)
	stream.data = samples
	stream.mix_rate = 48000
	stream.loop_mode = AudioStreamWAV.LOOP_FORWARD
	stream.loop_end = 96
	return stream


func new_source(place: Vector3) -> AulaSource3D:
	var source := AulaSource3D.new()
	source.position = place
	source.stream = tone()
	source.autoplay = place == NEAR
	return source


func new_room() -> AulaRoom:
	var room := AulaRoom.new()
	room.ir_length_s = 0.3
	room.rays = 100
	return room


## The level of the next 0.1 s.
func level_db() -> float:
	capture.clear_buffer()
	await get_tree().create_timer(0.1).timeout
	var energy := 0.0
	var sound := capture.get_buffer(capture.get_frames_available())
	for sample in sound:
		energy += sample.length_squared() / 2
	return 10 * log(energy / maxf(1, sound.size()) + 1e-12) / log(10)


## A room rings for seconds until a rebuild takes its walls away; its source then stops. The level
## in the 0.1 s after that, relative to the level before.
func level_after_rebuild(ir_length_s: float) -> float:
	var room := new_room()
	room.ir_length_s = 0
	var walls := AulaBody3D.new()
	walls.material = AulaMaterial.new()
	walls.material.preset = ""
	walls.material.absorption = PackedFloat32Array([0.05, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05])
	var mesh := MeshInstance3D.new()
	mesh.mesh = BoxMesh.new()
	mesh.mesh.size = Vector3(8, 4, 6)
	walls.add_child(mesh)
	room.add_child(walls)
	room.add_child(AulaListener3D.new())
	var source := new_source(NEAR)
	room.add_child(source)
	add_child(room)
	await wait_for_sound(true, "a source between walls is not heard")
	var before: float = await level_db()
	var length := room.response_length_s
	# The second one waits for the first one, which reads the walls.
	room.rebuild()
	walls.audible = false
	room.ir_length_s = ir_length_s
	room.rebuild()
	var start := Time.get_ticks_msec()
	while room.response_length_s == length and Time.get_ticks_msec() < start + 20000:
		await get_tree().process_frame
	source.stop()
	await get_tree().create_timer(MIX_S).timeout
	var after: float = await level_db()
	# It leaves while it gets another scene.
	room.rebuild()
	room.free()
	return after - before


func _ready() -> void:
	AudioServer.add_bus_effect(0, capture)
	# The room before rings out. A new room, with another length of the responses, cuts it off.
	var ringing: float = await level_after_rebuild(0)
	var cut: float = await level_after_rebuild(0.2)
	print("after a rebuild %.1f dB, in a new room %.1f dB" % [ringing, cut])
	expect(ringing > -20, "a rebuild cuts sound off")
	expect(cut < -40, "a new room rings as the one before")
	var room := new_room()
	var ears := AulaListener3D.new()
	room.add_child(ears)
	room.add_child(new_source(FAR))
	add_child(room)
	while room.response_length_s == 0:
		await get_tree().process_frame
	# More sources than places, the last of which is heard.
	for i in 19:
		room.add_child(new_source(FAR))
	var last := new_source(NEAR)
	room.add_child(last)
	await wait_for_sound(true, "source 21 is not heard")
	last.free()
	await wait_for_sound(false, "a source that is gone is heard")
	# The same while a room is made.
	room.rebuild()
	for i in 19:
		room.add_child(new_source(FAR))
	last = new_source(NEAR)
	room.add_child(last)
	await wait_for_sound(true, "a source that came while a room was made is not heard")
	# Across its axis a figure of eight is silent.
	last.directivity = "figure_of_eight"
	last.rotation.y = PI / 2
	room.rebuild()
	await wait_for_sound(false, "a rebuild does not read the directivity")
	room.free()
	# A source and listeners outside of the room stay when it goes.
	room = new_room()
	add_child(room)
	var source := new_source(NEAR)
	add_child(source)
	ears = AulaListener3D.new()
	add_child(ears)
	await wait_for_sound(true, "a source beside the room is not heard")
	remove_child(room)
	await wait_for_sound(false, "a source without a room is heard")
	add_child(room)
	expect(source.is_playing(), "a source does not play on in a room that comes again")
	await wait_for_sound(true, "a source is not heard in a room that comes again")
	# Another room takes over, before the one goes or later.
	var other := new_room()
	add_child(other)
	room.free()
	await wait_for_sound(true, "a source is not heard in another room")
	other.free()
	other = new_room()
	add_child(other)
	await wait_for_sound(true, "a source is not heard in a room that comes later")
	# The newest listener hears; when it goes, the one before.
	var newest := AulaListener3D.new()
	newest.position = FAR
	add_child(newest)
	await wait_for_sound(false, "the newest listener does not hear")
	newest.free()
	await wait_for_sound(true, "the listener before does not hear")
	source.stop()
	await get_tree().create_timer(0.1).timeout
	other.free()
	get_tree().quit(1 if failed else 0)
