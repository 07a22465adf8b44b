extends Node
## A small room that sounds, and quits.


func _ready() -> void:
	await get_tree().create_timer(0.3).timeout
	$Room/Source.stop()
	await get_tree().create_timer(0.1).timeout
	get_tree().quit()
