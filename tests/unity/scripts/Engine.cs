// As much of the engine as the scripts of the package call, for a test without the engine.
using System;
using System.Collections.Generic;
using System.Linq;

namespace UnityEngine
{
    [AttributeUsage(AttributeTargets.Class)]
    public sealed class CreateAssetMenuAttribute : Attribute { public string menuName; }
    [AttributeUsage(AttributeTargets.Class)]
    public sealed class RequireComponent : Attribute { public RequireComponent(Type type) { } }
    [AttributeUsage(AttributeTargets.Field)]
    public sealed class RangeAttribute : Attribute
    {
        public RangeAttribute(float least, float greatest) { }
    }

    public struct Vector3
    {
        public float x, y, z;
        public Vector3(float x, float y, float z) { this.x = x; this.y = y; this.z = z; }
        public static Vector3 right { get { return new Vector3(1, 0, 0); } }
        public static Vector3 up { get { return new Vector3(0, 1, 0); } }
        public static Vector3 forward { get { return new Vector3(0, 0, 1); } }
        public static Vector3 operator +(Vector3 a, Vector3 b)
        {
            return new Vector3(a.x + b.x, a.y + b.y, a.z + b.z);
        }
        public static Vector3 operator -(Vector3 a, Vector3 b)
        {
            return new Vector3(a.x - b.x, a.y - b.y, a.z - b.z);
        }
    }

    public struct Quaternion
    {
        public float x, y, z, w;
        public static Quaternion identity { get { return new Quaternion { w = 1 }; } }
        public static Quaternion AngleAxis(float degrees, Vector3 axis)
        {
            var half = degrees * Math.PI / 360;
            var s = (float)Math.Sin(half);
            return new Quaternion { x = s * axis.x, y = s * axis.y, z = s * axis.z,
                                    w = (float)Math.Cos(half) };
        }
        public static Quaternion Inverse(Quaternion q)
        {
            return new Quaternion { x = -q.x, y = -q.y, z = -q.z, w = q.w };
        }
        public static Quaternion operator *(Quaternion a, Quaternion b)
        {
            return new Quaternion
            {
                x = a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
                y = a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                z = a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
                w = a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z
            };
        }
        public static Vector3 operator *(Quaternion q, Vector3 v)
        {
            var p = q * new Quaternion { x = v.x, y = v.y, z = v.z } * Inverse(q);
            return new Vector3(p.x, p.y, p.z);
        }
    }

    public class Object
    {
        static int count;
        readonly int id = ++count;
        public string name = "";
        public int GetInstanceID() { return id; }

        public static T FindObjectOfType<T>() where T : Component
        {
            return FindObjectsOfType<T>().FirstOrDefault();
        }
        public static T[] FindObjectsOfType<T>() where T : Component
        {
            return Component.All.OfType<T>().ToArray();
        }
    }

    public class Component : Object
    {
        public static readonly List<Component> All = new List<Component>();
        public Transform transform;
        public T GetComponent<T>() where T : Component
        {
            return All.OfType<T>().FirstOrDefault(c => c.transform == transform);
        }
        public T[] GetComponentsInChildren<T>(bool includeInactive) where T : Component
        {
            return All.OfType<T>().Where(c => transform.Contains(c.transform)).ToArray();
        }
    }

    public class Behaviour : Component { public bool enabled = true; }
    public class MonoBehaviour : Behaviour { }
    public class ScriptableObject : Object { }

    public class Transform : Component
    {
        public Transform parent;
        public Vector3 position;
        public Quaternion rotation = Quaternion.identity;
        public Transform() { transform = this; }
        public Vector3 TransformPoint(Vector3 point) { return position + rotation * point; }
        public bool Contains(Transform other)
        {
            for (; other != null; other = other.parent)
                if (other == this) return true;
            return false;
        }
        public T Add<T>() where T : Component, new()
        {
            var component = new T { transform = this, name = name };
            All.Add(component);
            return component;
        }
        public static Transform New(string name, Transform parent, Vector3 position)
        {
            return new Transform { name = name, parent = parent, position = position };
        }
    }

    public class Mesh { public Vector3[] vertices; public int[] triangles; }
    public class MeshFilter : Component { public Mesh sharedMesh; }
    public class AudioListener : Behaviour { }
    public class AudioSource : Behaviour
    {
        public bool spatialize;
        public float spatialBlend;
        public readonly float[] parameters = new float[2];
        public bool SetSpatializerFloat(int index, float value)
        {
            parameters[index] = value;
            return true;
        }
    }

    public static class AudioSettings
    {
        public delegate void AudioConfigurationChangeHandler(bool deviceWasChanged);
        public static event AudioConfigurationChangeHandler OnAudioConfigurationChanged;
        public static int outputSampleRate = 48000;
        public static void Change(int rate)
        {
            outputSampleRate = rate;
            if (OnAudioConfigurationChanged != null) OnAudioConfigurationChanged(true);
        }
    }

    public static class Time { public static float realtimeSinceStartup; }

    public static class Debug
    {
        public static readonly List<string> Messages = new List<string>();
        public static void LogError(string text, Object about = null) { Messages.Add(text); }
        public static void LogWarning(string text, Object about = null) { Messages.Add(text); }
    }
}
