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

        /// What a thread makes a room of.
        sealed class Making
        {
            public IntPtr scene;
            public readonly List<ulong> sources = new List<ulong>();
            public readonly List<MovingObject> moving = new List<MovingObject>();
            public Task<IntPtr> room;
        }

        static AulaRoom heard;

        IntPtr room;
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
                if (making.room.Status == TaskStatus.RanToCompletion)
                    Native.aula_room_destroy(making.room.Result);
                making = null;
            }
            Replace(IntPtr.Zero);
        }

        void OnConfigurationChanged(bool deviceWasChanged)
        {
            Rebuild();
        }

        /// Reads the meshes and makes a room of them on a thread; the room before is heard until
        /// then. While one is made, the next waits.
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
            var status = new Native.Status();
            status.size = (UIntPtr)(ulong)Marshal.SizeOf(status);
            if (room != IntPtr.Zero) Native.aula_room_status(room, ref status);
            frameMs = status.frame_ms;
            periodMs = status.frame_period_ms;
        }

        Making Begin()
        {
            var made = new Making();
            Native.Check(Native.aula_scene_create(out made.scene));
            var owned = new List<IntPtr>();
            try
            {
                AddMeshes(made);
                AddPlaces(made);
                var listener = FindObjectOfType<AulaListener>();
                var options = new Native.Options();
                options.size = (UIntPtr)(ulong)Marshal.SizeOf(options);
                options.hrtf = Owned(owned, listener == null ? "" : listener.hrtf);
                options.headphones = Owned(owned, listener == null ? "" : listener.headphones);
                options.sample_rate_hz = AudioSettings.outputSampleRate;
                options.ir_length_s = responseLength;
                // Those of the places leave at the first sample.
                options.max_sources = Math.Min(1024, maxSources + made.sources.Count);
                options.rays = rays;
                made.room = Task.Run(() => Make(made, options, owned));
            }
            catch (AulaException)
            {
                Free(made.scene, owned);
                throw;
            }
            return made;
        }

        static IntPtr Make(Making made, Native.Options options, List<IntPtr> owned)
        {
            try
            {
                IntPtr result;
                Native.Check(Native.aula_room_create(made.scene, ref options, out result));
                foreach (var source in made.sources)
                    Native.aula_room_remove_source(result, source, Native.Now);
                return result;
            }
            finally
            {
                Free(made.scene, owned);
            }
        }

        static void Free(IntPtr scene, List<IntPtr> owned)
        {
            Native.aula_scene_destroy(scene);
            foreach (var text in owned) Marshal.FreeHGlobal(text);
        }

        /// A text that stays until the room is made.
        static IntPtr Owned(List<IntPtr> owned, string text)
        {
            if (string.IsNullOrEmpty(text)) return IntPtr.Zero;
            var bytes = Native.Bytes(text);
            var copy = Marshal.AllocHGlobal(bytes.Length);
            Marshal.Copy(bytes, 0, copy, bytes.Length);
            owned.Add(copy);
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
            Replace(made.room.Result);
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
            if (Native.aula_room_set_transform(room, moved.index, rows, Native.Now) == 0) return;
            try
            {
                Native.Check(2);
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
