using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using System.Threading.Tasks;
using UnityEngine;

namespace Aula
{
    /// Makes the meshes below it audible. One room is heard: the one that was made last.
    public sealed class AulaRoom : MonoBehaviour
    {
        /// Of meshes without a body that has one; none: plaster.
        public AulaMaterial material;
        /// Per source and frame; 0: the default of Aula.
        public int rays;
        /// Length of the responses in s; 0: as long as the room sounds.
        public float responseLength;
        /// Most sources that play at the same time.
        [Range(1, 1024)] public int maxSources = 32;

        sealed class MovingObject
        {
            public Transform body;
            public UIntPtr index;
            public Vector3 position;     // at rest
            public Quaternion rotation;  // at rest
            public readonly float[] transform = new float[12];
        }

        /// What only a new room can change.
        struct Settings
        {
            public string hrtf, headphones;
            public int sampleRate, maxSources, rays;
            public float responseLength;
        }

        /// What a thread makes audible.
        sealed class Making
        {
            public IntPtr scene;
            public Settings settings;
            public readonly List<ulong> sources = new List<ulong>();
            public readonly List<MovingObject> moving = new List<MovingObject>();
            public Task<IntPtr> room;  // the one that plays, or a new one
        }

        static AulaRoom heard;

        IntPtr room;
        Settings settings;  // of the room
        List<MovingObject> moving = new List<MovingObject>();
        Making making;
        bool isOutdated;
        float silentSince = -1;

        void OnEnable()
        {
            if (Native.aula_unity_prepare() != 0)
            {
                Debug.LogError("AulaRoom: a library is missing beside audiopluginaula");
                enabled = false;
                return;
            }
            AudioSettings.OnAudioConfigurationChanged += OnConfigurationChanged;
            Rebuild();
        }

        void OnDisable()
        {
            AudioSettings.OnAudioConfigurationChanged -= OnConfigurationChanged;
            if (making != null)
            {
                Wait(making);
                if (making.room.Status == TaskStatus.RanToCompletion && making.room.Result != room)
                    Native.aula_room_destroy(making.room.Result);
                making = null;
            }
            Replace(IntPtr.Zero);
        }

        void OnConfigurationChanged(bool deviceWasChanged)
        {
            Rebuild();
        }

        /// Reads the meshes and makes them audible on a thread; what was made before is heard until
        /// then, and rings out, unless the room gets other settings. While they are made audible,
        /// the next ones wait.
        public void Rebuild()
        {
            isOutdated = making != null;
            if (isOutdated) return;
            try
            {
                making = Begin();
            }
            catch (AulaException error)
            {
                Debug.LogError("AulaRoom " + name + ": " + error.Message, this);
            }
        }

        /// Whether the room is made.
        public bool IsReady { get { return room != IntPtr.Zero; } }

        /// Milliseconds that the newest propagation frame took, and the time between frames: above
        /// it the sound follows movements later. 0 without a room.
        public void GetLoad(out double frameMs, out double periodMs)
        {
            Native.Status status;
            GetStatus(out status);
            frameMs = status.frame_ms;
            periodMs = status.frame_period_ms;
        }

        /// Whether there is a room, without an error.
        bool GetStatus(out Native.Status status)
        {
            status = new Native.Status();
            status.size = (UIntPtr)(ulong)Marshal.SizeOf(status);
            return room != IntPtr.Zero && Native.aula_room_status(room, ref status) == 0;
        }

        Making Begin()
        {
            var made = new Making();
            Native.Check(Native.aula_scene_create(out made.scene));
            try
            {
                AddMeshes(made);
                AddPlaces(made);
            }
            catch (AulaException)
            {
                Native.aula_scene_destroy(made.scene);
                throw;
            }
            var listener = FindObjectOfType<AulaListener>();
            made.settings.hrtf = listener == null ? "" : listener.hrtf;
            made.settings.headphones = listener == null ? "" : listener.headphones;
            made.settings.sampleRate = AudioSettings.outputSampleRate;
            made.settings.maxSources = maxSources;
            made.settings.rays = rays;
            made.settings.responseLength = responseLength;
            Native.Status status;
            var stays = GetStatus(out status) && heard == this && made.settings.Equals(settings);
            var present = stays ? room : IntPtr.Zero;
            made.room = Task.Run(() => Make(made, present));
            return made;
        }

        /// Gives a room the scene, or makes one if there is none.
        static IntPtr Make(Making made, IntPtr present)
        {
            try
            {
                if (present == IntPtr.Zero) return MakeRoom(made);
                Native.Check(Native.aula_room_set_scene(present, made.scene, Native.Now));
                return present;
            }
            finally
            {
                Native.aula_scene_destroy(made.scene);
            }
        }

        static IntPtr MakeRoom(Making made)
        {
            var options = new Native.Options();
            options.size = (UIntPtr)(ulong)Marshal.SizeOf(options);
            options.sample_rate_hz = made.settings.sampleRate;
            options.ir_length_s = made.settings.responseLength;
            // Those of the places leave at the first sample.
            options.max_sources = Math.Min(1024, made.settings.maxSources + made.sources.Count);
            options.rays = made.settings.rays;
            try
            {
                options.hrtf = Copy(made.settings.hrtf);
                options.headphones = Copy(made.settings.headphones);
                IntPtr result;
                Native.Check(Native.aula_room_create(made.scene, ref options, out result));
                foreach (var source in made.sources)
                    Native.aula_room_remove_source(result, source, Native.Now);
                return result;
            }
            finally
            {
                Marshal.FreeHGlobal(options.hrtf);
                Marshal.FreeHGlobal(options.headphones);
            }
        }

        /// To be freed; null if the text is empty.
        static IntPtr Copy(string text)
        {
            if (string.IsNullOrEmpty(text)) return IntPtr.Zero;
            var bytes = Native.Bytes(text);
            var copy = Marshal.AllocHGlobal(bytes.Length);
            Marshal.Copy(bytes, 0, copy, bytes.Length);
            return copy;
        }

        void AddMeshes(Making made)
        {
            var added = new HashSet<string>();
            foreach (var filter in GetComponentsInChildren<MeshFilter>(true))
            {
                if (filter.sharedMesh == null) continue;
                AulaBody mover = null, dressed = null;
                var isAudible = true;
                for (var at = filter.transform; at != null && at != transform; at = at.parent)
                {
                    var body = at.GetComponent<AulaBody>();
                    if (body == null) continue;
                    isAudible &= body.audible;
                    if (mover == null && body.moving) mover = body;
                    if (dressed == null && body.material != null) dressed = body;
                }
                if (!isAudible) continue;
                var chosen = dressed != null ? dressed.material : material;
                var surface = chosen == null ? "plaster" : chosen.AddTo(made.scene, added);
                AddMesh(made, filter, surface, mover);
            }
        }

        /// With vertices in the world and the axes of Aula: x to the front, y to the left, z up.
        void AddMesh(Making made, MeshFilter filter, string surface, AulaBody mover)
        {
            var vertices = filter.sharedMesh.vertices;
            var indices = filter.sharedMesh.triangles;
            if (indices.Length == 0) return;
            var coordinates = new float[3 * vertices.Length];
            for (int i = 0; i < vertices.Length; ++i)
            {
                var point = filter.transform.TransformPoint(vertices[i]);
                coordinates[3 * i] = point.z;
                coordinates[3 * i + 1] = -point.x;
                coordinates[3 * i + 2] = point.y;
            }
            UIntPtr index;
            Native.Check(Native.aula_scene_add_object(made.scene,
                Native.Bytes(filter.name + " " + filter.GetInstanceID()), coordinates,
                (UIntPtr)(ulong)vertices.Length, Array.ConvertAll(indices, i => (uint)i),
                (UIntPtr)(ulong)(indices.Length / 3), Native.Bytes(surface), mover == null ? 0 : 1,
                out index));
            if (mover == null) return;
            made.moving.Add(new MovingObject
            {
                body = mover.transform,
                index = index,
                position = mover.transform.position,
                rotation = mover.transform.rotation
            });
        }

        /// A room is prepared for where its sources and its listener are when it is made. The
        /// spatializers add sources of their own.
        void AddPlaces(Making made)
        {
            foreach (var source in FindObjectsOfType<AudioSource>())
            {
                if (!source.spatialize || made.sources.Count == maxSources) continue;
                var pose = Native.PoseAt(source.transform.position);
                ulong number;
                Native.Check(Native.aula_scene_add_source(made.scene,
                    Native.Bytes("place " + made.sources.Count), ref pose, null, 0, out number));
                made.sources.Add(number);
            }
            var listener = FindObjectOfType<AudioListener>();
            if (listener == null) return;
            var head = Native.PoseAt(listener.transform.position);
            Native.Check(Native.aula_scene_set_listener(made.scene, ref head));
        }

        void Update()
        {
            if (making != null && making.room.IsCompleted) Finish();
            if (making == null && isOutdated) Rebuild();
            if (room == IntPtr.Zero || heard != this) return;
            foreach (var moved in moving) Move(moved);
            var problem = Native.TakeProblem();
            if (problem != null) Debug.LogError("AulaRoom " + name + ": " + problem, this);
            WarnIfSilent();
        }

        void Finish()
        {
            var made = making;
            making = null;
            Wait(made);
            if (made.room.Exception != null)
            {
                Debug.LogError("AulaRoom " + name + ": " +
                    made.room.Exception.InnerException.Message, this);
                return;
            }
            moving = made.moving;
            settings = made.settings;
            if (made.room.Result != room) Replace(made.room.Result);
            isOutdated |= heard != this;  // another room is heard meanwhile
        }

        static void Wait(Making made)
        {
            ((IAsyncResult)made.room).AsyncWaitHandle.WaitOne();
        }

        /// Plays another room, or none, and destroys the room before.
        void Replace(IntPtr other)
        {
            if (other != IntPtr.Zero)
            {
                Native.aula_unity_play(other);
                heard = this;
            }
            else if (heard == this)
            {
                Native.aula_unity_play(IntPtr.Zero);
                heard = null;
            }
            Native.aula_room_destroy(room);
            room = other;
        }

        void Move(MovingObject moved)
        {
            if (moved.body == null) return;  // destroyed
            // What leads from the rest to now, in rows of the axes of Aula.
            var turn = moved.body.rotation * Quaternion.Inverse(moved.rotation);
            var offset = moved.body.position - turn * moved.position;
            Vector3 x = turn * Vector3.right, y = turn * Vector3.up, z = turn * Vector3.forward;
            var rows = new[]
            {
                z.z, -x.z, y.z, offset.z,
                -z.x, x.x, -y.x, -offset.x,
                z.y, -x.y, y.y, offset.y
            };
            var isNew = false;
            for (int i = 0; i < rows.Length; ++i) isNew |= rows[i] != moved.transform[i];
            if (!isNew) return;
            rows.CopyTo(moved.transform, 0);
            var result = Native.aula_room_set_transform(room, moved.index, rows, Native.Now);
            // The thread may just have given the room other objects, which all move when it ends.
            if (result == 0 || making != null) return;
            try
            {
                Native.Check(result);
            }
            catch (AulaException error)
            {
                Debug.LogError("AulaRoom " + name + ": " + error.Message, this);
            }
        }

        void WarnIfSilent()
        {
            if (Native.aula_unity_is_heard() != 0)
                silentSince = -1;
            else if (silentSince == -1)
                silentSince = Time.realtimeSinceStartup;
            else if (silentSince >= 0 && Time.realtimeSinceStartup > silentSince + 2)
            {
                silentSince = -2;  // once
                Debug.LogWarning("AulaRoom " + name + ": no group of an Audio Mixer that plays " +
                    "has the effect Aula Room", this);
            }
        }
    }
}
