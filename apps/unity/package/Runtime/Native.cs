using System;
using System.Runtime.InteropServices;
using System.Text;
using UnityEngine;

namespace Aula
{
    /// What Aula refuses, in one line.
    public sealed class AulaException : Exception
    {
        public AulaException(string message) : base(message) { }
    }

    /// The functions of aula.h and of the plugin.
    static class Native
    {
        const string Library = "audiopluginaula";

        [StructLayout(LayoutKind.Sequential)]
        public struct Pose
        {
            public float x, y, z, yaw_rad, pitch_rad, roll_rad;
        }

        /// aula_options.
        [StructLayout(LayoutKind.Sequential)]
        public struct Options
        {
            public UIntPtr size;
            public IntPtr hrtf;
            public double sample_rate_hz;
            public double frame_rate_hz;
            public double ir_length_s;
            public int clock;
            public int output;
            public int block;
            public int ambisonic_order;
            public int half_precision_tail;
            public int follow_paths;
            public int listeners;
            public int max_sources;
            public int rays;
            public int threads;
            public ulong max_memory_bytes;
            public IntPtr headphones;
        }

        /// aula_status.
        [StructLayout(LayoutKind.Sequential)]
        public struct Status
        {
            public UIntPtr size;
            public long samples;
            public ulong frames;
            public ulong late_frames;
            public double frame_ms;
            public double frame_mean_ms;
            public double frame_worst_ms;
            public double frame_period_ms;
            public double frame_age_s;
            public double response_length_s;
            public long tail_samples;
            public ulong memory_bytes;
            public int rays;
            public int channels;
            public int latency_samples;
            public int sources;
            public ulong skipped_frames;
            public long muted_samples;
        }

        /// AULA_NOW.
        public const long Now = long.MinValue;

        [DllImport(Library)] public static extern int aula_unity_prepare();
        [DllImport(Library)] public static extern void aula_unity_play(IntPtr room);
        [DllImport(Library)] public static extern int aula_unity_is_heard();
        [DllImport(Library)] public static extern int aula_unity_take_problem(byte[] text, int size);
        [DllImport(Library)] static extern IntPtr aula_message();
        [DllImport(Library)] public static extern int aula_scene_create(out IntPtr scene);
        [DllImport(Library)] public static extern void aula_scene_destroy(IntPtr scene);
        [DllImport(Library)]
        public static extern int aula_scene_add_material(IntPtr scene, byte[] name,
            float[] absorption, float[] scattering, float[] sound_reduction_db);
        [DllImport(Library)]
        public static extern int aula_scene_add_object(IntPtr scene, byte[] name, float[] vertices,
            UIntPtr vertex_count, uint[] triangles, UIntPtr triangle_count, byte[] material,
            int movable, out UIntPtr index);
        [DllImport(Library)]
        public static extern int aula_scene_add_source(IntPtr scene, byte[] name, ref Pose pose,
            byte[] directivity, float gain_db, out ulong source);
        [DllImport(Library)]
        public static extern int aula_scene_set_listener(IntPtr scene, ref Pose pose);
        [DllImport(Library)]
        public static extern int aula_room_create(IntPtr scene, ref Options options,
            out IntPtr room);
        [DllImport(Library)] public static extern void aula_room_destroy(IntPtr room);
        [DllImport(Library)]
        public static extern int aula_room_set_scene(IntPtr room, IntPtr scene, long at);
        [DllImport(Library)]
        public static extern int aula_room_remove_source(IntPtr room, ulong source, long at);
        [DllImport(Library)]
        public static extern int aula_room_set_transform(IntPtr room, UIntPtr index,
            float[] transform, long at);
        [DllImport(Library)]
        public static extern int aula_room_status(IntPtr room, ref Status status);

        /// Throws AulaException if a result is an error.
        public static void Check(int result)
        {
            if (result != 0) throw new AulaException(Text(aula_message()));
        }

        /// UTF-8, ended by a zero; null stays null.
        public static byte[] Bytes(string text)
        {
            return text == null ? null : Encoding.UTF8.GetBytes(text + "\0");
        }

        static string Text(IntPtr text)
        {
            int length = 0;
            while (Marshal.ReadByte(text, length) != 0) ++length;
            var bytes = new byte[length];
            Marshal.Copy(text, bytes, 0, length);
            return Encoding.UTF8.GetString(bytes);
        }

        /// The newest problem of a source or the listener; null if there is none.
        public static string TakeProblem()
        {
            var bytes = new byte[512];
            if (aula_unity_take_problem(bytes, bytes.Length) == 0) return null;
            return Encoding.UTF8.GetString(bytes, 0, Array.IndexOf(bytes, (byte)0));
        }

        /// A place of the world of the engine, without a turn.
        public static Pose PoseAt(Vector3 position)
        {
            return new Pose { x = position.z, y = -position.x, z = position.y };
        }
    }
}
