extends Node
## Plays the house in real time and prints how loud it is with the door shut and open, and what it
## costs; then removes it and adds it again five times.

## The house is read in some 10 ms, and made in about 1200 ms.
const MOST_WAIT_MS := 400

var capture := AudioEffectCapture.new()
var failed := false


func level_db() -> float:
	capture.clear_buffer()
	await get_tree().create_timer(2.0).timeout
	var energy := 0.0
	var sound := capture.get_buffer(capture.get_frames_available())
	for sample in sound:
		energy += sample.length_squared() / 2
	return 10 * log(energy / maxf(1, sound.size()) + 1e-12) / log(10)


## The level as soon as it is within bounds; a loaded machine takes some seconds.
func level_within(low: float, high: float) -> float:
	var level: float = await level_db()
	for i in 9:
		if level > low and level < high:
			break
		level = await level_db()
	return level


func expect(holds: bool, text: String) -> void:
	if not holds:
		failed = true
		print("failed: ", text)


func _ready() -> void:
	capture.buffer_length = 4
	AudioServer.add_bus_effect(0, capture)
	var buses := AudioServer.bus_count
	var scene: PackedScene = load("res://house.tscn")
	var house: AulaRoom = scene.instantiate()
	add_child(house)
	var start := Time.get_ticks_msec()
	while house.response_length_s == 0 and Time.get_ticks_msec() < start + 60000:
		await get_tree().process_frame
	# One room is made at a time, and nothing waits for it.
	var asked := Time.get_ticks_msec()
	house.rebuild()
	house.rebuild()
	house.rebuild()
	expect(Time.get_ticks_msec() < asked + MOST_WAIT_MS, "rebuild() waits for a room")
	var passing := AulaSource3D.new()
	house.add_child(passing)
	await get_tree().process_frame
	passing.free()
	await get_tree().create_timer(2.0).timeout
	var shut: float = await level_db()
	house.get_node("Door").toggle()
	var open: float = await level_within(shut + 5, INF)
	print("shut %.1f dB, open %.1f dB" % [shut, open])
	expect(shut > -60, "nothing is heard")
	expect(open > shut + 5, "the door does not muffle")
	expect(house.frame_ms > 0 and house.audio_load_percent > 0, "no costs")
	expect(Performance.get_custom_monitor("Aula House/frame_ms") > 0, "no monitor")
	expect(AudioServer.bus_count == buses + 2, "other buses than those of room and radio")
	var radio: AulaSource3D = house.get_node("Radio")
	expect(radio.is_playing(), "the radio does not play")
	# The radio comes near while another room is made.
	house.ir_length_s = 0.5
	house.rebuild()
	for i in 3:
		await get_tree().process_frame
	expect(house.response_length_s != 0.5, "the room was made at once")
	radio.global_position = house.get_node("Player/Head").global_position + Vector3(0.5, 0, 0)
	asked = Time.get_ticks_msec()
	while house.response_length_s != 0.5 and Time.get_ticks_msec() < asked + 60000:
		await get_tree().process_frame
	await get_tree().create_timer(0.5).timeout
	var near: float = await level_within(open + 6, INF)
	expect(near > open + 6, "a radio that came near is %.1f dB loud" % near)
	radio.stop()
	expect(not radio.is_playing(), "the radio plays on")
	remove_child(house)
	expect(AudioServer.bus_count == buses, "buses remain")
	expect(not Performance.has_custom_monitor("Aula House/frame_ms"), "monitors remain")
	house.free()
	# A room into which the radio comes later.
	house = scene.instantiate()
	radio = house.get_node("Radio")
	radio.owner = null
	house.remove_child(radio)
	add_child(house)
	var begin := Time.get_ticks_msec()
	while house.response_length_s == 0 and Time.get_ticks_msec() < begin + 60000:
		await get_tree().process_frame
	var length := house.response_length_s
	house.add_child(radio)
	while house.response_length_s == length and Time.get_ticks_msec() < begin + 60000:
		await get_tree().process_frame
	expect(house.response_length_s > 2, "the room does not know how long it sounds")
	var late: float = await level_within(shut - 6, shut + 6)
	expect(absf(late - shut) < 6, "a radio that came later is %.1f dB loud" % late)
	radio.stop()
	remove_child(house)
	house.free()
	for i in 5:
		house = scene.instantiate()
		add_child(house)
		await get_tree().process_frame
		await get_tree().process_frame
		house.get_node("Radio").stop()
		asked = Time.get_ticks_msec()
		remove_child(house)
		house.free()
		expect(Time.get_ticks_msec() < asked + MOST_WAIT_MS, "a room that leaves is waited for")
		await get_tree().create_timer(0.1).timeout
	print("objects ", Performance.get_monitor(Performance.OBJECT_COUNT))
	get_tree().quit(1 if failed else 0)
