using System;
using UnityEngine;

namespace Aula
{
    /// What a surface does to sound.
    [CreateAssetMenu(menuName = "Aula/Material")]
    public sealed class AulaMaterial : ScriptableObject
    {
        /// The name of a material that ships with Aula, as "brick"; empty: the values below.
        public string preset = "plaster";

        /// Shares of the incident energy that are not reflected, 63 Hz to 8 kHz.
        public float[] absorption = new float[8];
        /// Shares of the reflected energy that leave diffusely.
        public float[] scattering = new float[8];
        /// Sound reduction index, dB; no values: opaque.
        public float[] soundReductionDb = new float[0];

        /// Its name in the scene, into which it is added unless it ships.
        internal string AddTo(IntPtr scene, System.Collections.Generic.HashSet<string> added)
        {
            if (!string.IsNullOrEmpty(preset)) return preset;
            var unique = "AulaMaterial " + GetInstanceID();
            if (!added.Add(unique)) return unique;
            if (absorption.Length != 8 || scattering.Length != 8 ||
                (soundReductionDb.Length != 0 && soundReductionDb.Length != 8))
                throw new AulaException(name + ": expected 8 values, of the octaves");
            Native.Check(Native.aula_scene_add_material(scene, Native.Bytes(unique), absorption,
                scattering, soundReductionDb.Length == 0 ? null : soundReductionDb));
            return unique;
        }
    }
}
