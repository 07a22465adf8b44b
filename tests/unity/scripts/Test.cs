// The scripts of the package make, move and remake a room of the plugin.
using System;
using System.Reflection;
using System.Threading;
using Aula;
using UnityEngine;

static class Test
{
    static void Demand(bool holds, string what)
    {
        if (holds) return;
        Console.Error.WriteLine("not so: " + what + "; " + string.Join("; ", Debug.Messages));
        Environment.Exit(1);
    }

    static void Call(object behaviour, string method)
    {
        behaviour.GetType().GetMethod(method, BindingFlags.NonPublic | BindingFlags.Instance)
            .Invoke(behaviour, null);
    }

    /// Pictures until something holds, at most a minute.
    static void Await(AulaRoom room, Func<bool> holds, string what)
    {
        for (int i = 0; i < 6000 && !holds(); ++i)
        {
            Thread.Sleep(10);
            Call(room, "Update");
        }
        Demand(holds(), what);
    }

    static object Get(AulaRoom room, string field)
    {
        return room.GetType().GetField(field, BindingFlags.NonPublic | BindingFlags.Instance)
            .GetValue(room);
    }

    static bool IsBeingMade(AulaRoom room)
    {
        return Get(room, "making") != null;
    }

    static Mesh Box(float x, float y, float z)
    {
        var mesh = new Mesh { vertices = new Vector3[8] };
        for (int i = 0; i < 8; ++i)
            mesh.vertices[i] =
                new Vector3(x * (i & 1), y * (i >> 1 & 1), z * (i >> 2 & 1));
        mesh.triangles = new[] { 0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 3, 7, 1, 7, 5 };
        return mesh;
    }

    static int Main()
    {
        var root = Transform.New("room", null, new Vector3());
        var room = root.Add<AulaRoom>();
        room.responseLength = 0.3F;
        room.rays = 200;
        Transform.New("walls", root, new Vector3()).Add<MeshFilter>().sharedMesh = Box(8, 3, 6);
        var hinge = Transform.New("door", root, new Vector3(3, 0, 1));
        var door = hinge.Add<AulaBody>();
        door.moving = true;
        door.material = new AulaMaterial { preset = "partition_hollow_door" };
        Transform.New("leaf", hinge, new Vector3(3, 0, 1)).Add<MeshFilter>().sharedMesh =
            Box(0.04F, 2, 0.9F);
        var dummy = Transform.New("dummy", root, new Vector3(5, 1, 1));
        dummy.Add<AulaBody>().audible = false;
        dummy.Add<MeshFilter>().sharedMesh =
            new Mesh { vertices = new Vector3[1], triangles = new[] { 0, 0, 7 } };

        var place = Transform.New("radio", null, new Vector3(2, 1, 3));
        var player = place.Add<AudioSource>();
        var source = place.Add<AulaSource>();
        source.gainDb = -3;
        source.directivity = AulaDirectivity.Talker;
        Call(source, "Awake");
        Call(source, "Update");
        Demand(player.spatialize && player.spatialBlend == 1, "the source is spatialized");
        Demand(player.parameters[0] == -3 && player.parameters[1] == 5, "it has its parameters");
        Transform.New("head", null, new Vector3(6, 1.6F, 4)).Add<AudioListener>();

        // It is made on a thread, and computes frames.
        Call(room, "OnEnable");
        Await(room, () => room.IsReady, "the room is made");
        double frame = 0, period = 0;
        Await(room, () => { room.GetLoad(out frame, out period); return frame > 0; }, "it computes");
        Demand(Math.Abs(period - 1000.0 / 30) < 1e-6, "a frame lasts a 30th of a second");
        Demand(Debug.Messages.Count == 0, "nothing is wrong");

        // The door turns: what is not rigid is refused, so the matrix is a rotation.
        for (int i = 1; i <= 10; ++i)
        {
            hinge.rotation = Quaternion.AngleAxis(9 * i, Vector3.up);
            hinge.position = hinge.position + new Vector3(0.01F, 0, 0);
            Call(room, "Update");
        }
        Demand(Debug.Messages.Count == 0, "the door moves");

        // No effect of a mixer renders it: that is said once.
        Time.realtimeSinceStartup += 3;
        Call(room, "Update");
        Time.realtimeSinceStartup += 3;
        Call(room, "Update");
        Demand(Debug.Messages.Count == 1 && Debug.Messages[0].Contains("Audio Mixer"), "silence");

        // Another sample rate, and a material of its own.
        Debug.Messages.Clear();
        room.material = new AulaMaterial { preset = "" };
        AudioSettings.Change(44100);
        Await(room, () => !IsBeingMade(room), "it is made again");
        Demand(Debug.Messages.Count == 0 && room.IsReady, "with a material of its own");

        // The room stays and gets other meshes, and the door is moved in it, too. Another length of
        // the responses needs another room.
        var before = Get(room, "room");
        Transform.New("wall", root, new Vector3(5, 0, 1)).Add<MeshFilter>().sharedMesh =
            Box(0.1F, 2, 2);
        room.Rebuild();
        Await(room, () => !IsBeingMade(room), "the meshes are read again");
        Demand(before.Equals(Get(room, "room")), "the room stays");
        hinge.rotation = Quaternion.identity;
        Call(room, "Update");
        room.responseLength = 0.2F;
        room.Rebuild();
        Await(room, () => !IsBeingMade(room), "a room with another length is made");
        Demand(!before.Equals(Get(room, "room")), "it is a new one");
        Demand(Debug.Messages.Count == 0 && room.IsReady, "nothing is wrong with both");

        // What is wrong is one line, and the room before remains.
        foreach (var wrong in new[] { new AulaMaterial { preset = "gold" },
                                      new AulaMaterial { preset = "", absorption = new float[3] } })
        {
            Debug.Messages.Clear();
            room.material = wrong;
            room.Rebuild();
            Demand(!IsBeingMade(room) && room.IsReady, "the old room remains");
            Demand(Debug.Messages.Count == 1 && !Debug.Messages[0].Contains("\n"), "one line");
        }
        Demand(Debug.Messages[0].Contains("expected 8 values"), "it says what was expected");

        Debug.Messages.Clear();
        room.material = null;
        var head =
            UnityEngine.Object.FindObjectOfType<AudioListener>().transform.Add<AulaListener>();
        head.hrtf = "/nowhere.sofa";
        room.Rebuild();
        Await(room, () => !IsBeingMade(room), "the attempt ends");
        Demand(Debug.Messages.Count == 1 && Debug.Messages[0].Contains("/nowhere.sofa"), "the HRTF");

        // It leaves while it gets other meshes.
        head.hrtf = "";
        room.Rebuild();
        Call(room, "OnDisable");
        Demand(!room.IsReady && !IsBeingMade(room), "it is gone");
        return 0;
    }
}
